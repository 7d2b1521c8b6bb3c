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

// Reads the network that libsumo has loaded; throws what libsumo throws. kInvalidArgument names the lane or
// edge that the scenario has wrong.
Result<ScenarioPlan> PlanScenario(const Scenario& scenario, TrafficProfile profile);

}  // namespace dadrl
