// What the lanes and edges that a scenario names must be on its network, which libsumo has loaded. Every
// function throws what libsumo throws.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/road_map.h"
#include "actor/sim/scenario.h"
#include "common/util/result.h"

namespace dadrl {

// "EDGE_INDEX".
std::string LaneId(const std::string& edge, int lane);

// The lanes of `edge`, which is in the network, that vehicles of `vehicle_class` may use.
std::vector<int> OpenLanes(const std::string& edge, const std::string& vehicle_class);

// The lanes of the ego's route, those inside junctions included. kInvalidArgument, with file, line and
// remedy: one is not there, is closed to cars or leads elsewhere, or there is nothing left to drive.
Result<std::vector<int>> EgoLanes(const Scenario& scenario, const RoadMap& map);

// kInvalidArgument, with file, line and remedy: vehicles of `vehicle_class` cannot drive the flow. `edges`:
// all of the network.
Status CheckFlow(const Scenario& scenario, const TrafficFlow& flow, const std::vector<std::string>& edges,
                 const std::string& vehicle_class);

}  // namespace dadrl
