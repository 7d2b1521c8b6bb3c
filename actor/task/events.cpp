#include "actor/task/events.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "actor/task/collision.h"

namespace dadrl {
namespace {

constexpr double kOncomingAngle = 175.0 * std::numbers::pi / 180.0;
constexpr double kOncomingLaneWidths = 1.1;

// Directly or through one junction.
bool LeadsToRoute(const RoadMap& map, const Route& route, int lane) {
  return std::ranges::any_of(map.CrossingsFrom(lane),
                             [&](const std::vector<int>& way) { return route.OnRoute(way.back()); });
}

}  // namespace

EventDetector::EventDetector(const RoadMap& map, const Route& route) : map_(map), route_(route) {
  for (size_t lane = 0; lane < map.lanes().size(); ++lane) {
    leads_to_route_.push_back(LeadsToRoute(map, route, lane));
  }
}

Events EventDetector::Detect(const WorldState& world, const EgoLocation& location) const {
  Events events;
  events.collision = EgoTouchesAny(world);
  events.off_road = map_.OffRoad(world.ego.pose.position, world.ego.elevation_m);
  events.goal = Norm(world.ego.pose.position - route_.goal()) <= kGoalRadius;
  events.wrong_way = WrongWay(world.ego.pose, location);
  events.off_route = OffRoute(location, events.wrong_way);
  return events;
}

bool EventDetector::WrongWay(const Pose& ego, const EgoLocation& location) const {
  if (!location.nearest) return false;
  if (map_.lane(location.nearest->lane).internal) return false;
  return std::abs(WrapAngle(ego.heading - location.nearest->heading)) > std::numbers::pi / 2;
}

bool EventDetector::OffRoute(const EgoLocation& location, bool wrong_way) const {
  if (!location.nearest) return true;
  const int lane = location.nearest->lane;
  if (map_.lane(lane).internal || route_.OnRoute(lane)) return false;
  if (OncomingPartner(*location.nearest)) return false;
  return wrong_way || !leads_to_route_[static_cast<size_t>(lane)];
}

bool EventDetector::OncomingPartner(const LanePosition& position) const {
  const Point here = map_.lane(position.lane).centre.At(position.s);
  for (size_t i = 0; i < map_.lanes().size(); ++i) {
    const Lane& lane = map_.lanes()[i];
    if (lane.internal || !route_.OnRoute(i)) continue;
    const Polyline::Projection projection = lane.centre.Project(here);
    const double turn = std::abs(WrapAngle(lane.centre.HeadingAt(projection.s) - position.heading));
    if (projection.distance <= kOncomingLaneWidths * lane.width && turn > kOncomingAngle) return true;
  }
  return false;
}

}  // namespace dadrl
