#include "actor/sim/sumo_traffic.h"

#include <libsumo/libsumo.h>

#include <algorithm>
#include <map>
#include <utility>

#include "actor/sim/sumo_pose.h"

namespace dadrl {
namespace {

// Streams of an episode's seed.
enum SeedStream : uint64_t { kDriverStream, kSumoStream, kLoopStream };

}  // namespace

SumoTraffic::SumoTraffic(const Scenario& scenario, const ProfileSettings& profile, const ScenarioPlan& plan,
                         MemoryFile route_file)
    : scenario_(scenario), profile_(profile), plan_(plan), route_file_(std::move(route_file)) {}

std::vector<std::string> SumoTraffic::SumoOptions(uint64_t seed) const {
  // A map, because SUMO refuses an option that is given twice.
  std::map<std::string, std::string> options{
      {"net-file", scenario_.network.string()},
      {"route-files", route_file_.path()},
      {"step-length", fmt::format("{}", kStepSeconds)},
      {"seed", fmt::format("{}", DeriveSeed(seed, kSumoStream) & 0x7fffffff)},
      {"time-to-teleport", "-1"},
      {"collision.action", "none"},
      {"no-step-log", "true"},
      {"no-warnings", "true"},
      {"xml-validation", "never"},
      {"xml-validation.net", "never"},
  };
  for (const auto& [name, value] : profile_.sumo_options) options[name] = value;
  std::vector<std::string> arguments;
  for (const auto& [name, value] : options) {
    arguments.push_back("--" + name);
    arguments.push_back(value);
  }
  return arguments;
}

Status SumoTraffic::Load(uint64_t seed, const EgoTraffic& ego) {
  Random driver_random(DeriveSeed(seed, kDriverStream));
  const std::vector<DriverType> types = DrawDriverTypes(scenario_.driver_types, driver_random);
  loop_random_ = Random(DeriveSeed(seed, kLoopStream));
  presence_.assign(static_cast<size_t>(scenario_.population()), Presence::kWaiting);
  ego_in_network_ = ego_arrived_ = false;
  DADRL_RETURN_IF_ERROR(route_file_.Write(TrafficXml(scenario_, profile_, types, plan_.lane_end_m, ego)));
  libsumo::Simulation::load(SumoOptions(seed));
  return {};
}

void SumoTraffic::AddDrivenEgo() {
  const Lane& lane = plan_.map.lanes()[static_cast<size_t>(plan_.route.lanes().front())];
  libsumo::Vehicle::add(kEgoId, kEgoId, kEgoId, "now", std::to_string(lane.index), "0", "0");
  // No check of SUMO's may keep the ego from what it is told.
  libsumo::Vehicle::setSpeedMode(kEgoId, 0);
  libsumo::Vehicle::setLaneChangeMode(kEgoId, 0);
}

void SumoTraffic::Step() {
  libsumo::Simulation::step();
  for (const std::string& id : libsumo::Simulation::getArrivedIDList()) {
    if (id == kEgoId) {
      ego_arrived_ = true;
    } else {
      Reenter(id);
    }
  }
}

void SumoTraffic::Reenter(const std::string& id) {
  const int vehicle = SocialIndex(id);
  const int flow = vehicle / scenario_.driver_types;
  const int lanes = plan_.departure_lanes[static_cast<size_t>(flow)];
  const uint64_t lane = loop_random_.Below(static_cast<uint64_t>(lanes));
  libsumo::Vehicle::add(id, FlowId(flow), TypeId(vehicle % scenario_.driver_types), "now",
                        std::to_string(lane), "0", "0");
  presence_[static_cast<size_t>(vehicle)] = Presence::kWaiting;
}

Status SumoTraffic::Read(std::vector<SocialVehicle>& vehicles) {
  vehicles.clear();
  ego_in_network_ = false;
  for (const std::string& id : libsumo::Vehicle::getIDList()) {
    const int vehicle = SocialIndex(id);
    if (vehicle < 0) {
      ego_in_network_ = true;
      continue;
    }
    vehicles.push_back({vehicle, PoseFromSumo(id), libsumo::Vehicle::getSpeed(id),
                        plan_.map.FindLane(libsumo::Vehicle::getLaneID(id))});
  }
  std::sort(vehicles.begin(), vehicles.end(),
            [](const SocialVehicle& a, const SocialVehicle& b) { return a.id < b.id; });
  return CheckNoneVanished(vehicles);
}

Status SumoTraffic::CheckNoneVanished(const std::vector<SocialVehicle>& vehicles) {
  auto next = vehicles.begin();
  for (size_t vehicle = 0; vehicle < presence_.size(); ++vehicle) {
    if (next != vehicles.end() && next->id == static_cast<int>(vehicle)) {
      ++next;
      presence_[vehicle] = Presence::kInNetwork;
    } else if (presence_[vehicle] == Presence::kInNetwork) {
      return Fail(ErrorCode::kInternal, "vehicle {} vanished from the traffic",
                  SocialId(static_cast<int>(vehicle)));
    }
  }
  return {};
}

}  // namespace dadrl
