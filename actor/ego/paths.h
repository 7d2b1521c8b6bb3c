// The ways a vehicle can take along the route: one a lane, and one a branch where the lanes fork.
#pragma once

#include <vector>

#include "actor/ego/lane_sequences.h"
#include "actor/sim/polyline.h"
#include "actor/sim/road_map.h"
#include "actor/sim/route.h"

namespace dadrl {

struct Path {
  LaneSequence lanes;
  Polyline centre;
  // What the curve allows at each metre, m/s; infinite where there is none.
  std::vector<double> speed_caps;
};

// A path for each lane sequence, in their order.
std::vector<Path> FindPaths(const RoadMap& map, const Route& route);

// The path that stays longest on the route's own lanes.
int PathOfRoute(const std::vector<Path>& paths, const Route& route);

// Which of two paths is to the left of the other, worked out where it is asked for and kept. Not thread safe.
class PathSides {
 public:
  // Keeps a reference to `paths`.
  explicit PathSides(const std::vector<Path>& paths);

  // How far `path` is to the left of `other`, in metres, where the two first part on the 24 m from `metre` of
  // `path` on; 0 where they do not.
  double At(int path, int other, size_t metre);

 private:
  const std::vector<Path>& paths_;
  // By path and other: by metre, not a number where nobody asked yet; empty where nobody asked at all.
  std::vector<std::vector<double>> sides_;
};

}  // namespace dadrl
