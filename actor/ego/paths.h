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
  // What the curve allows at each metre, m/s; infinite where there is none.
  std::vector<double> speed_caps;
  // sides[p][i]: how far this path is to the left of path p, in metres, where the two first part on the 24 m
  // from metre i of this path on; 0 where they do not.
  std::vector<std::vector<double>> sides;
};

// Every lane of every edge that can be reached along the route belongs to at least one path. Where a lane
// forks, a path takes the branches that stay on the route; a lane that does not lead on along the route is
// followed to where it ends. In no particular order.
std::vector<Path> FindPaths(const RoadMap& map, const Route& route);

// The path that stays longest on the route's own lanes.
int PathOfRoute(const std::vector<Path>& paths, const Route& route);

}  // namespace dadrl
