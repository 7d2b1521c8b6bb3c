// The ways a vehicle can take along the route: one a lane, and one a branch where the lanes fork.
#pragma once

#include <vector>

#include "actor/sim/polyline.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"

namespace dadrl {

// Immutable after construction.
struct Path {
  std::vector<int> lanes;  // in driving order, internal ones included
  Polyline centre;
  std::vector<double> speed_caps;  // by metre of the centre line: what its curve allows, m/s
};

// Every lane of every edge that can be reached along the route belongs to at least one path. A path prefers
// lanes of the route where a lane forks; a lane that does not lead on along the route is followed to where it
// ends. Ordered from the rightmost to the leftmost; paths that share a lane and part later stand in the order
// of their branches.
std::vector<Path> FindPaths(const RoadMap& map, const Route& route);

}  // namespace dadrl
