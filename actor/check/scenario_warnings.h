// What makes a scenario other than its author will have meant it.
#pragma once

#include <string>
#include <vector>

#include "actor/check/scenario_report.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/scenario.h"

namespace dadrl {

// The centre lines that vehicles of the flow drive along, one an edge: of the rightmost lane that cars may
// use. An edge without one is left out.
std::vector<const Lane*> LanesOfFlow(const RoadMap& map, const TrafficFlow& flow);
double FlowLength(const RoadMap& map, const TrafficFlow& flow);
// Whether it comes within 15 m of the ego's route.
bool MeetsRoute(const RoadMap& map, const TrafficFlow& flow, const Route& route);

// One sentence each, with the remedy.
std::vector<std::string> WarningsOf(const ScenarioReport& report);

}  // namespace dadrl
