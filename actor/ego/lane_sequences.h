// Which lanes a vehicle can follow along the route, one after another.
#pragma once

#include <vector>

#include "actor/sim/road_map.h"
#include "actor/sim/route.h"

namespace dadrl {

// Lanes in driving order, internal ones included.
using LaneSequence = std::vector<int>;

// Every lane of every edge that can be reached along the route, and of the edges next to it, is in at least
// one sequence. Where a lane forks, there is a sequence for each branch that stays on the route; a lane that
// does not lead on along the route is followed through each branch of the next junction, from there straight
// on, and for a few hundred metres. There are about as many sequences as branches, whatever the size of the
// network. The order is that of a depth-first search.
std::vector<LaneSequence> FindLaneSequences(const RoadMap& map, const Route& route);

}  // namespace dadrl
