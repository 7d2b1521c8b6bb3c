// The way from one edge to another, lane by lane.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/road_map.h"
#include "common/util/result.h"

namespace dadrl {

// The shortest way over the lanes of `map` from the beginning of edge `from` to the end of edge `to`, where a
// lane change counts as 100 m more: as a scenario's ego.lanes names it, lanes inside junctions left out.
// kInvalidArgument: an edge that is not there or closed to cars, with the nearest ones, or no way between.
Result<std::vector<std::string>> FindLanes(const RoadMap& map, const std::string& from,
                                           const std::string& to);

}  // namespace dadrl
