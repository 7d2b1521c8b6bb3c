// Where the ego is: on which lane, and how far along its route. Computed once a step, used by the
// observation, the events, the reward and the metrics.
#pragma once

#include <optional>

#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// A lane farther than this from the ego's centre is not looked at: half the box's diagonal plus 5 m
// (SMARTS' off-route test).
constexpr double kLaneSearchRadius = 6.98;
// The ego is on a lane whose centre line is at most one lane width away.
constexpr double kOnLaneDistance = 3.2;

struct EgoLocation {
  std::optional<LanePosition> nearest;  // within kLaneSearchRadius
  int lane_index = -1;                  // 0 is the rightmost; -1 off the lanes
  double speed_limit = 0.0;             // m/s, of the lane the ego is on; 0 off the lanes
  double route_s = 0.0;                 // metres along the route
  double remaining = 1.0;               // fraction of the route still to drive, in [0, 1]
};

// Keeps the last place on the route, so that a route which comes near itself is not jumped along. Borrows
// map and route. Not thread safe; allocates nothing.
class Localizer {
 public:
  Localizer(const RoadMap& map, const Route& route) : map_(map), route_(route) {}

  // An episode starts: the next Locate may be anywhere on the route.
  void Reset() { started_ = false; }
  // `elevation_m`: of the road under the ego.
  EgoLocation Locate(const Pose& ego, double elevation_m = 0.0);

 private:
  const RoadMap& map_;
  const Route& route_;
  bool started_ = false;
  double route_s_ = 0.0;
};

}  // namespace dadrl
