#include "actor/sim/scenario_plan.h"

#include <libsumo/libsumo.h>

#include <exception>

#include "actor/sim/scenario_rules.h"
#include "actor/sim/sumo_network.h"
#include "actor/sim/traffic.h"
#include "actor/sim/world_state.h"

namespace dadrl {
namespace {

// Throws what libsumo throws.
Result<ScenarioPlan> Plan(const Scenario& scenario, TrafficProfile profile) {
  RoadMap map = ReadSumoNetwork();
  DADRL_ASSIGN_OR_RETURN(const std::vector<int> lanes, EgoLanes(scenario, map));
  const Lane& first = map.lane(lanes.front());
  const Lane& last = map.lane(lanes.back());
  const Point front = first.centre.At(scenario.ego_start_offset_m);
  const double heading = first.centre.HeadingAt(scenario.ego_start_offset_m);
  Route route(map, lanes, front, last.centre.points().back());
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
  for (const int index : lanes) {
    const Lane& lane = map.lane(index);
    if (lane.internal || (!plan.ego_edges.empty() && plan.ego_edges.back() == lane.edge)) continue;
    plan.ego_edges.push_back(lane.edge);
  }
  const std::string vehicle_class = VehicleClass(scenario.profile(profile));
  const std::vector<std::string> edges = libsumo::Edge::getIDList();
  for (const TrafficFlow& flow : scenario.flows) {
    DADRL_RETURN_IF_ERROR(CheckFlow(scenario, flow, edges, vehicle_class));
    plan.lane_end_m.push_back(libsumo::Lane::getLength(LaneId(flow.edges.front(), flow.depart_lane)));
    plan.departure_lanes.push_back(OpenLanes(flow.edges.front(), vehicle_class));
  }
  return plan;
}

}  // namespace

Result<ScenarioPlan> LoadPlan(const Scenario& scenario, TrafficProfile profile) {
  DADRL_RETURN_IF_ERROR(LoadSumoNetwork(scenario.network));
  try {
    return Plan(scenario, profile);
  } catch (const std::exception& exception) {
    return Fail(ErrorCode::kInternal, "SUMO failed reading {}: {}", scenario.network.string(),
                exception.what());
  }
}

}  // namespace dadrl
