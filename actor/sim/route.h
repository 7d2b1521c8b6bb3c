// The ego's way from start to goal: the lane sequence it should drive, and progress along it.
#pragma once

#include <string>
#include <vector>

#include "actor/sim/polyline.h"
#include "actor/sim/road_map.h"
#include "common/util/result.h"

namespace dadrl {

// Fills in the lanes inside the junctions between the named `lane_ids`. Two consecutive names are either
// joined by a connection of the network or lie side by side on one edge (a lane change). kInvalidArgument
// names the unknown lane or the pair that nothing joins.
Result<std::vector<int>> ConnectLanes(const RoadMap& map, const std::vector<std::string>& lane_ids);

// Immutable. The centre line runs from the ego's start to the goal through the lanes it should be in; where
// the route changes lanes, it does so over the first metres of the edge.
class Route {
 public:
  // `lanes`: the lanes to follow in order, internal ones included; a lane may follow its left or right
  // neighbour (a lane change). `start` and `goal` are projected on the first and the last lane.
  Route(const RoadMap& map, std::vector<int> lanes, Point start, Point goal);

  const Polyline& centre() const { return centre_; }
  const std::vector<int>& lanes() const { return lanes_; }
  double length() const { return centre_.length(); }
  Point goal() const { return goal_; }
  // True for every lane of an edge that the route uses, whichever lane of it, and for every lane inside a
  // junction that leads from one such edge to the next.
  bool OnRoute(int lane) const;
  // Fraction driven, in [0, 1].
  double Progress(Point point) const;

 private:
  void MarkLanesOnRoute(const RoadMap& map);

  Polyline centre_;
  std::vector<int> lanes_;
  std::vector<bool> on_route_;
  Point goal_;
};

}  // namespace dadrl
