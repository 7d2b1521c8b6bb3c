// What a scenario means on its network: checked once, used by every episode.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/scenario.h"

namespace dadrl {

struct ScenarioPlan {
  RoadMap map;
  Route route;
  Point start_front;  // of the ego's front bumper
  Pose start;         // of its centre
  double start_elevation_m = 0.0;
  double start_offset_m = 0.0;         // SUMO's measure, which is not always the geometric one
  std::vector<std::string> ego_edges;  // of the route
  std::vector<double> lane_end_m;      // SUMO's length of each flow's departure lane
  // Of each flow's first edge: the lanes that the population may use. Never empty.
  std::vector<std::vector<int>> departure_lanes;
};

// Loads the scenario's network into libsumo and reads it. kInvalidArgument: SUMO cannot read it, or the
// scenario names a lane or an edge wrongly; with place and remedy. Nothing is thrown.
Result<ScenarioPlan> LoadPlan(const Scenario& scenario, TrafficProfile profile);

}  // namespace dadrl
