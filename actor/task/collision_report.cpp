#include "actor/task/collision_report.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "actor/task/collision.h"

namespace dadrl {
namespace {

// Of the ego.
constexpr double kHalfLength = kVehicleLength / 2;
constexpr double kHalfWidth = kVehicleWidth / 2;
// Farther off the lane's heading a vehicle crosses it, it does not drive along it.
constexpr double kAlong = std::numbers::pi / 4;

// The part of the polygon where Dot(normal, p) <= bound (Sutherland and Hodgman, 1974).
std::vector<Point> Clip(const std::vector<Point>& polygon, Point normal, double bound) {
  std::vector<Point> kept;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Point from = polygon[i];
    const Point to = polygon[(i + 1) % polygon.size()];
    const double from_excess = Dot(normal, from) - bound;
    const double to_excess = Dot(normal, to) - bound;
    if (from_excess <= 0.0) kept.push_back(from);
    if ((from_excess <= 0.0) != (to_excess <= 0.0)) {
      kept.push_back(from + (from_excess / (from_excess - to_excess)) * (to - from));
    }
  }
  return kept;
}

// The middle of what `other` shares with the ego's box, in the ego's frame. Boxes that touch without
// overlapping share something once the ego's is as much larger as touching allows.
Point ContactPoint(const Pose& ego, const OrientedBox& other) {
  const double half_length = other.length / 2;
  const double half_width = other.width / 2;
  const Point ahead = Forward(other.pose.heading);
  const Point left{-ahead.y, ahead.x};
  std::vector<Point> shared;
  for (const Point corner : {Point{half_length, half_width}, Point{-half_length, half_width},
                             Point{-half_length, -half_width}, Point{half_length, -half_width}}) {
    shared.push_back(ToLocal(ego, other.pose.position + corner.x * ahead + corner.y * left));
  }
  for (const double sign : {1.0, -1.0}) {
    shared = Clip(shared, {sign, 0}, kHalfLength + kContactDistance);
    shared = Clip(shared, {0, sign}, kHalfWidth + kContactDistance);
  }
  Point sum;
  for (const Point p : shared) sum = sum + p;
  return (1.0 / (std::max<size_t>(shared.size(), 1))) * sum;
}

// The side of the ego's box that the point is nearest to, seen from the middle.
ContactSide SideOf(Point contact) {
  if (std::abs(contact.x) / kHalfLength >= std::abs(contact.y) / kHalfWidth) {
    return contact.x >= 0 ? ContactSide::kFront : ContactSide::kRear;
  }
  return contact.y > 0 ? ContactSide::kLeft : ContactSide::kRight;
}

const SocialVehicle* NearestTouched(const WorldState& world) {
  const SocialVehicle* nearest = nullptr;
  double distance = std::numeric_limits<double>::infinity();
  for (const SocialVehicle& vehicle : world.vehicles) {
    if (!BoxesWithin(EgoBox(world.ego.pose), vehicle.box(), kContactDistance)) continue;
    const double centres = Norm(vehicle.pose.position - world.ego.pose.position);
    if (centres >= distance) continue;
    distance = centres;
    nearest = &vehicle;
  }
  return nearest;
}

bool LeavesItsLane(const Pose& vehicle, const std::optional<LanePosition>& nearest, const RoadMap& map) {
  return nearest && !map.lane(nearest->lane).internal && nearest->distance > kLaneKeepingOffset &&
         std::abs(WrapAngle(vehicle.heading - nearest->heading)) < kAlong;
}

}  // namespace

std::optional<CollisionSummary> DescribeCollision(const WorldState& world, const EgoLocation& location,
                                                  const RoadMap& map) {
  const SocialVehicle* const other = NearestTouched(world);
  if (other == nullptr) return std::nullopt;
  const Pose& ego = world.ego.pose;
  const bool ego_leaves = LeavesItsLane(ego, location.nearest, map);
  const auto other_nearest =
      map.NearestLane(other->pose.position, other->pose.heading, kLaneSearchRadius, other->elevation_m);
  const bool other_leaves = LeavesItsLane(other->pose, other_nearest, map);
  CollisionSummary collision;
  collision.side = SideOf(ContactPoint(ego, other->box()));
  collision.ego_speed_mps = world.ego.speed_mps;
  collision.other_speed_mps = other->speed_mps;
  collision.relative_heading_rad = WrapAngle(other->pose.heading - ego.heading);
  collision.junction = location.nearest && map.lane(location.nearest->lane).internal;
  collision.lane_changer = ego_leaves ? (other_leaves ? LaneChanger::kBoth : LaneChanger::kEgo)
                                      : (other_leaves ? LaneChanger::kOther : LaneChanger::kNobody);
  return collision;
}

}  // namespace dadrl
