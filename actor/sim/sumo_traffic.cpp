#include "actor/sim/sumo_traffic.h"

#include <libsumo/libsumo.h>

#include <map>
#include <utility>

#include "actor/sim/sumo_options.h"
#include "actor/sim/sumo_pose.h"

namespace dadrl {
namespace {

// Streams of an episode's seed.
enum SeedStream : uint64_t { kDriverStream, kSumoStream, kLoopStream };

}  // namespace

SumoTraffic::SumoTraffic(const Scenario& scenario, const ProfileSettings& profile, const ScenarioPlan& plan,
                         MemoryFile route_file)
    : scenario_(scenario),
      profile_(profile),
      plan_(plan),
      route_file_(std::move(route_file)),
      true_size_(SaysWhatDrives(profile)) {}

std::vector<std::string> SumoTraffic::SumoOptions(uint64_t seed) const {
  // A map, because SUMO refuses an option that is given twice.
  std::map<std::string, std::string> options{
      {"net-file", scenario_.network.string()},
      {kRouteFiles, route_file_.path()},
      {"step-length", fmt::format("{}", kStepSeconds)},
      // Also what SUMO would do by itself: it refuses every other spelling of what is given.
      {"begin", "0"},
      {"end", "-1"},
      {"random", "false"},
      {"seed", fmt::format("{}", DeriveSeed(seed, kSumoStream) & 0x7fffffff)},
      {"time-to-teleport", "-1"},
      {"collision.action", "none"},
      {"no-step-log", "true"},
      {"no-warnings", "true"},
      {"xml-validation", "never"},
      {"xml-validation.net", "never"},
  };
  for (const auto& [name, value] : profile_.sumo_options) {
    const bool more_routes = name == kRouteFiles;
    options[name] = more_routes ? options[name] + "," + value : value;
  }
  std::vector<std::string> arguments;
  for (const auto& [name, value] : options) {
    arguments.push_back("--" + name);
    arguments.push_back(value);
  }
  return arguments;
}

Status SumoTraffic::Load(uint64_t seed, const EgoTraffic& ego) {
  Random driver_random(DeriveSeed(seed, kDriverStream));
  const std::vector<DriverType> types = SampleDriverTypes(scenario_.driver_types, driver_random);
  loop_random_ = Random(DeriveSeed(seed, kLoopStream));
  vehicles_.clear();
  others_.clear();
  for (int vehicle = 0; vehicle < scenario_.population(); ++vehicle)
    vehicles_.push_back({.id = SocialId(vehicle)});
  ego_in_network_ = ego_arrived_ = false;
  DADRL_RETURN_IF_ERROR(route_file_.Write(TrafficXml(scenario_, profile_, types, plan_.lane_end_m, ego)));
  libsumo::Simulation::load(SumoOptions(seed));
  return {};
}

void SumoTraffic::AddDrivenEgo() {
  const Lane& lane = plan_.map.lane(plan_.route.lanes().front());
  libsumo::Vehicle::add(kEgoId, kEgoId, kEgoId, "now", std::to_string(lane.index), "0", "0");
  // No check of SUMO's may keep the ego from what it is told.
  libsumo::Vehicle::setSpeedMode(kEgoId, 0);
  libsumo::Vehicle::setLaneChangeMode(kEgoId, 0);
}

void SumoTraffic::Step() {
  libsumo::Simulation::step();
  for (const std::string& id : libsumo::Simulation::getDepartedIDList()) Enter(id);
  for (const std::string& id : libsumo::Simulation::getStartingTeleportIDList()) {
    if (id != kEgoId) vehicles_[IndexOf(id)].in_network = false;
  }
  for (const std::string& id : libsumo::Simulation::getEndingTeleportIDList()) Enter(id);
  for (const std::string& id : libsumo::Simulation::getArrivedIDList()) Leave(id);
}

size_t SumoTraffic::IndexOf(const std::string& id) {
  const int social = SocialIndex(id);
  if (social >= 0 && social < scenario_.population()) return static_cast<size_t>(social);
  const auto [found, is_new] = others_.try_emplace(id, vehicles_.size());
  if (is_new) vehicles_.push_back({.id = id});
  return found->second;
}

void SumoTraffic::Enter(const std::string& id) {
  if (id == kEgoId) {
    ego_in_network_ = true;
    return;
  }
  const size_t index = IndexOf(id);
  Vehicle& vehicle = vehicles_[index];
  vehicle.in_network = true;
  ++vehicle.trip;
  if (std::cmp_less(index, scenario_.population()) && !true_size_) return;
  vehicle.length_m = libsumo::Vehicle::getLength(id);
  vehicle.width_m = libsumo::Vehicle::getWidth(id);
}

void SumoTraffic::Leave(const std::string& id) {
  if (id == kEgoId) {
    ego_in_network_ = false;
    ego_arrived_ = true;
    return;
  }
  const size_t vehicle = IndexOf(id);
  vehicles_[vehicle].in_network = false;
  if (std::cmp_less(vehicle, scenario_.population())) Reenter(vehicle);
}

void SumoTraffic::Reenter(size_t vehicle) {
  const size_t types = static_cast<size_t>(scenario_.driver_types);
  const std::vector<int>& lanes = plan_.departure_lanes[vehicle / types];
  const int lane = lanes[loop_random_.Below(lanes.size())];
  libsumo::Vehicle::add(vehicles_[vehicle].id, FlowId(vehicle / types), TypeId(vehicle % types), "now",
                        std::to_string(lane), "0", "0");
}

Status SumoTraffic::Read(std::vector<SocialVehicle>& vehicles) const {
  vehicles.clear();
  for (size_t index = 0; index < vehicles_.size(); ++index) {
    const Vehicle& vehicle = vehicles_[index];
    if (!vehicle.in_network) continue;
    const int lane = libsumo::Vehicle::getLaneIndex(vehicle.id);
    if (lane == libsumo::INVALID_INT_VALUE) {
      return Fail(ErrorCode::kInternal, "vehicle {} vanished from the traffic", vehicle.id);
    }
    vehicles.push_back({.id = static_cast<int>(index),
                        .pose = PoseFromSumo(vehicle.id, vehicle.length_m),
                        .speed_mps = libsumo::Vehicle::getSpeed(vehicle.id),
                        .lane_index = lane,
                        .trip = vehicle.trip,
                        .length_m = vehicle.length_m,
                        .width_m = vehicle.width_m,
                        .elevation_m = plan_.map.has_levels() ? ElevationFromSumo(vehicle.id) : 0.0});
  }
  return {};
}

}  // namespace dadrl
