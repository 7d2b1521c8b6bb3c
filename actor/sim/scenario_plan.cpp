#include "actor/sim/scenario_plan.h"

#include <fmt/ranges.h>
#include <libsumo/libsumo.h>

#include <algorithm>

#include "actor/sim/sumo_network.h"
#include "actor/sim/traffic.h"
#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

std::string LaneId(const std::string& edge, int lane) { return fmt::format("{}_{}", edge, lane); }

bool IsInNetwork(const std::vector<std::string>& ids, const std::string& id) {
  return std::ranges::find(ids, id) != ids.end();
}

// The lanes of `edge` that vehicles of `vehicle_class` may use; `edge` is in the network.
std::vector<int> OpenLanes(const std::string& edge, const std::string& vehicle_class) {
  std::vector<int> lanes;
  for (int lane = 0; lane < libsumo::Edge::getLaneNumber(edge); ++lane) {
    if (LaneAllows(LaneId(edge, lane), vehicle_class)) lanes.push_back(lane);
  }
  return lanes;
}

Status CheckLane(const std::string& edge, int lane, const std::string& vehicle_class) {
  if (lane >= libsumo::Edge::getLaneNumber(edge)) {
    return Fail(ErrorCode::kInvalidArgument, "traffic.flows: edge '{}' has no lane {}", edge, lane);
  }
  const std::vector<int> open = OpenLanes(edge, vehicle_class);
  if (std::ranges::find(open, lane) != open.end()) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "traffic.flows: lane {} of edge '{}' is closed to vClass {}; open to it: {}", lane, edge,
              vehicle_class, open.empty() ? "none" : fmt::format("{}", fmt::join(open, ", ")));
}

Status CheckFlow(const TrafficFlow& flow, const std::vector<std::string>& edges,
                 const std::string& vehicle_class) {
  for (const std::string& edge : flow.edges) {
    if (IsInNetwork(edges, edge)) continue;
    return Fail(ErrorCode::kInvalidArgument, "traffic.flows: edge '{}' is not in the network", edge);
  }
  DADRL_RETURN_IF_ERROR(CheckLane(flow.edges.front(), flow.depart_lane, vehicle_class));
  return CheckLane(flow.edges.back(), flow.arrival_lane, vehicle_class);
}

// The map has only what is open to cars: tells a closed lane from one that is not there.
Status CheckOpenToEgo(const RoadMap& map, const std::vector<std::string>& lane_ids) {
  const std::vector<std::string> all = libsumo::Lane::getIDList();
  for (const std::string& id : lane_ids) {
    if (map.FindLane(id) >= 0 || !IsInNetwork(all, id)) continue;
    return Fail(ErrorCode::kInvalidArgument, "lane '{}' is closed to cars", id);
  }
  return {};
}

Result<std::vector<int>> EgoLanes(const RoadMap& map, const std::vector<std::string>& lane_ids) {
  DADRL_RETURN_IF_ERROR(CheckOpenToEgo(map, lane_ids));
  return ConnectLanes(map, lane_ids);
}

Result<ScenarioPlan> Plan(const Scenario& scenario, TrafficProfile profile) {
  RoadMap map = ReadSumoNetwork();
  auto lanes = EgoLanes(map, scenario.ego_lanes);
  if (!lanes) return Fail(ErrorCode::kInvalidArgument, "ego.lanes: {}", lanes.error().message);
  const Lane& first = map.lane(lanes->front());
  const Lane& last = map.lane(lanes->back());
  if (scenario.ego_start_offset_m > first.centre.length()) {
    return Fail(ErrorCode::kInvalidArgument, "ego.start_offset_m: {} exceeds lane '{}' of {:.2f} m",
                scenario.ego_start_offset_m, first.id, first.centre.length());
  }
  const Point front = first.centre.At(scenario.ego_start_offset_m);
  const double heading = first.centre.HeadingAt(scenario.ego_start_offset_m);
  Route route(map, *lanes, front, last.centre.points().back());
  ScenarioPlan plan{.map = map,
                    .route = std::move(route),
                    .start_front = front,
                    .start = {},
                    .start_elevation_m = first.centre.ElevationAt(scenario.ego_start_offset_m),
                    .start_offset_m = 0,
                    .ego_edges = {},
                    .lane_end_m = {},
                    .departure_lanes = {}};
  plan.start = {front - (kVehicleLength / 2.0) * Forward(heading), heading};
  plan.start_offset_m =
      scenario.ego_start_offset_m * libsumo::Lane::getLength(first.id) / first.centre.length();
  for (const int index : *lanes) {
    const Lane& lane = map.lane(index);
    if (lane.internal || (!plan.ego_edges.empty() && plan.ego_edges.back() == lane.edge)) continue;
    plan.ego_edges.push_back(lane.edge);
  }
  const std::string vehicle_class = VehicleClass(scenario.profile(profile));
  const std::vector<std::string> edges = libsumo::Edge::getIDList();
  for (const TrafficFlow& flow : scenario.flows) {
    DADRL_RETURN_IF_ERROR(CheckFlow(flow, edges, vehicle_class));
    plan.lane_end_m.push_back(libsumo::Lane::getLength(LaneId(flow.edges.front(), flow.depart_lane)));
    plan.departure_lanes.push_back(OpenLanes(flow.edges.front(), vehicle_class));
  }
  return plan;
}

}  // namespace

Result<ScenarioPlan> PlanScenario(const Scenario& scenario, TrafficProfile profile) {
  auto plan = Plan(scenario, profile);
  if (plan) return plan;
  return Fail(plan.error().code, "scenario '{}': {}", scenario.name, plan.error().message);
}

}  // namespace dadrl
