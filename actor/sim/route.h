// The ego's way from start to goal: the lane sequence it should drive, and the lanes beside it.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/polyline.h"
#include "actor/sim/road_map.h"

namespace dadrl {

// Immutable. The centre line runs from the ego's start to the goal through the lanes it should be in (the
// lane-change point, where a route has one, is smoothed out over some metres); progress is arc length along
// it.
class Route {
 public:
  // `lanes`: the lanes to follow in order, internal ones included; a lane may follow its left or right
  // neighbour (a lane change). `alternatives`: centre lines of the parallel paths that lane commands can
  // choose, rightmost first, each aligned to run over the whole route.
  Route(const RoadMap& map, std::vector<int> lanes, Point start, Point goal);

  const Polyline& centre() const { return centre_; }
  const std::vector<int>& lanes() const { return lanes_; }
  double length() const { return centre_.length(); }
  Point goal() const { return goal_; }
  // True for every lane of an edge that the route uses, whichever lane of it.
  bool OnRoute(int lane) const;
  // Fraction driven, in [0, 1].
  double Progress(Point point) const;

 private:
  Polyline centre_;
  std::vector<int> lanes_;
  std::vector<bool> on_route_;
  Point goal_;
};

}  // namespace dadrl
