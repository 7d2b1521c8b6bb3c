#include "actor/sim/scenario_plan.h"

#include <libsumo/libsumo.h>

#include "actor/sim/sumo_network.h"
#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

std::string LaneId(const std::string& edge, int lane) { return fmt::format("{}_{}", edge, lane); }

int LaneCount(const RoadMap& map, const std::string& edge) {
  int lanes = 0;
  while (map.FindLane(LaneId(edge, lanes)) >= 0) ++lanes;
  return lanes;
}

Status CheckFlow(const RoadMap& map, const TrafficFlow& flow) {
  for (const std::string& edge : flow.edges) {
    if (LaneCount(map, edge) > 0) continue;
    return Fail(ErrorCode::kInvalidArgument, "traffic.flows: edge '{}' is not in the network", edge);
  }
  for (const auto& [edge, lane] :
       {std::pair(flow.edges.front(), flow.depart_lane), std::pair(flow.edges.back(), flow.arrival_lane)}) {
    if (lane < LaneCount(map, edge)) continue;
    return Fail(ErrorCode::kInvalidArgument, "traffic.flows: edge '{}' has no lane {}", edge, lane);
  }
  return {};
}

Result<ScenarioPlan> Plan(const Scenario& scenario) {
  RoadMap map = ReadSumoNetwork();
  auto lanes = ConnectLanes(map, scenario.ego_lanes);
  if (!lanes) return Fail(ErrorCode::kInvalidArgument, "ego.lanes: {}", lanes.error().message);
  const Lane& first = map.lanes()[static_cast<size_t>(lanes->front())];
  const Lane& last = map.lanes()[static_cast<size_t>(lanes->back())];
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
                    .start_offset_m = 0,
                    .ego_edges = {},
                    .lane_end_m = {},
                    .departure_lanes = {}};
  plan.start = {front - (kVehicleLength / 2.0) * Forward(heading), heading};
  plan.start_offset_m =
      scenario.ego_start_offset_m * libsumo::Lane::getLength(first.id) / first.centre.length();
  for (const int index : *lanes) {
    const Lane& lane = map.lanes()[static_cast<size_t>(index)];
    if (lane.internal || (!plan.ego_edges.empty() && plan.ego_edges.back() == lane.edge)) continue;
    plan.ego_edges.push_back(lane.edge);
  }
  for (const TrafficFlow& flow : scenario.flows) {
    DADRL_RETURN_IF_ERROR(CheckFlow(map, flow));
    plan.lane_end_m.push_back(libsumo::Lane::getLength(LaneId(flow.edges.front(), flow.depart_lane)));
    plan.departure_lanes.push_back(LaneCount(map, flow.edges.front()));
  }
  return plan;
}

}  // namespace

Result<ScenarioPlan> PlanScenario(const Scenario& scenario) {
  auto plan = Plan(scenario);
  if (plan) return plan;
  return Fail(plan.error().code, "scenario '{}': {}", scenario.name, plan.error().message);
}

}  // namespace dadrl
