#include "actor/sim/sumo_traffic.h"

#include <libsumo/libsumo.h>

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
    : scenario_(scenario), profile_(profile), plan_(plan), route_file_(std::move(route_file)) {
  for (int vehicle = 0; vehicle < scenario_.population(); ++vehicle) ids_.push_back(SocialId(vehicle));
}

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
  in_network_.assign(ids_.size(), false);
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
  for (const std::string& id : libsumo::Simulation::getDepartedIDList()) {
    if (id == kEgoId) {
      ego_in_network_ = true;
    } else {
      in_network_[static_cast<size_t>(SocialIndex(id))] = true;
    }
  }
  for (const std::string& id : libsumo::Simulation::getArrivedIDList()) {
    if (id == kEgoId) {
      ego_in_network_ = false;
      ego_arrived_ = true;
    } else {
      Reenter(SocialIndex(id));
    }
  }
}

void SumoTraffic::Reenter(int vehicle) {
  const int flow = vehicle / scenario_.driver_types;
  const int lanes = plan_.departure_lanes[static_cast<size_t>(flow)];
  const uint64_t lane = loop_random_.Below(static_cast<uint64_t>(lanes));
  libsumo::Vehicle::add(ids_[static_cast<size_t>(vehicle)], FlowId(flow),
                        TypeId(vehicle % scenario_.driver_types), "now", std::to_string(lane), "0", "0");
  in_network_[static_cast<size_t>(vehicle)] = false;
}

Status SumoTraffic::Read(std::vector<SocialVehicle>& vehicles) const {
  vehicles.clear();
  for (size_t vehicle = 0; vehicle < ids_.size(); ++vehicle) {
    if (!in_network_[vehicle]) continue;
    const std::string& id = ids_[vehicle];
    const int lane = libsumo::Vehicle::getLaneIndex(id);
    if (lane == libsumo::INVALID_INT_VALUE) {
      return Fail(ErrorCode::kInternal, "vehicle {} vanished from the traffic", id);
    }
    vehicles.push_back({static_cast<int>(vehicle), PoseFromSumo(id), libsumo::Vehicle::getSpeed(id), lane});
  }
  return {};
}

}  // namespace dadrl
