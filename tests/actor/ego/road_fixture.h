// Small roads, built by hand.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "actor/sim/road_map.h"

namespace dadrl {

inline Lane MakeLane(std::string id, int index, std::vector<Point> points, std::vector<int> successors = {}) {
  Lane lane;
  lane.edge = id.substr(0, id.rfind('_'));
  lane.internal = id.front() == ':';
  lane.id = std::move(id);
  lane.index = index;
  lane.speed_limit = 13.89;
  lane.centre = Polyline(points);
  lane.successors = std::move(successors);
  return lane;
}

// Two lanes to the east, 2 km.
inline RoadMap StraightRoad() {
  return RoadMap({MakeLane("a_0", 0, {{0, 0}, {2000, 0}}), MakeLane("a_1", 1, {{0, 3.2}, {2000, 3.2}})}, {});
}

}  // namespace dadrl
