// Small road networks whose answers can be worked out by hand.
#pragma once

#include <cmath>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"

namespace dadrl::test {

// `p` turned by `angle` about the origin, then moved.
inline Point Moved(Point p, double angle, Point shift) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return Point{c * p.x - s * p.y, s * p.x + c * p.y} + shift;
}

inline Lane MakeLane(std::string id, std::string edge, int index, double limit, std::vector<Point> points,
                     std::vector<int> successors = {}) {
  Lane lane;
  lane.id = std::move(id);
  lane.edge = std::move(edge);
  lane.index = index;
  lane.speed_limit = limit;
  lane.centre = Polyline(points);
  lane.successors = std::move(successors);
  lane.internal = lane.edge.starts_with(":");
  return lane;
}

// One edge east, 200 m long: lane 0 on y = 0, lane 1 on y = 3.2, limit 10; beside it a lane west ("back") on
// y = 6.4; the whole turned by `angle` about the origin and moved by `shift`.
inline RoadMap StraightRoad(double angle = 0.0, Point shift = {}) {
  const auto at = [&](double x, double y) { return Moved({x, y}, angle, shift); };
  std::vector<Lane> lanes;
  lanes.push_back(MakeLane("road_0", "road", 0, 10.0, {at(0, 0), at(200, 0)}));
  lanes.push_back(MakeLane("road_1", "road", 1, 10.0, {at(0, 3.2), at(200, 3.2)}));
  lanes.push_back(MakeLane("back_0", "back", 0, 10.0, {at(200, 6.4), at(0, 6.4)}));
  return RoadMap(std::move(lanes), {});
}

// Along lane 0 of StraightRoad from x = 10 to x = 110: 100 m.
inline Route StraightRoute(const RoadMap& map, double angle = 0.0, Point shift = {}) {
  return Route(map, {0}, Moved({10, 0}, angle, shift), Moved({110, 0}, angle, shift));
}

inline WorldState WorldWithEgo(double x, double y, double heading = 0.0, double speed = 0.0) {
  WorldState world;
  world.ego.pose = {{x, y}, heading};
  world.ego.speed_mps = speed;
  world.ego.velocity_lon = speed;
  return world;
}

inline SocialVehicle Vehicle(int id, double x, double y, double heading = 0.0, double speed = 0.0,
                             int lane_index = 0) {
  return {id, {{x, y}, heading}, speed, lane_index};
}

}  // namespace dadrl::test
