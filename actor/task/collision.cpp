#include "actor/task/collision.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dadrl {
namespace {

using Corners = std::array<Point, 4>;

// Corners of `box` in the frame of `frame`.
Corners LocalCorners(const Pose& frame, const OrientedBox& box) {
  const Point centre = ToLocal(frame, box.pose.position);
  const Point f = Forward(box.pose.heading - frame.heading);
  const Point ahead = box.length / 2 * f;
  const double half_width = box.width / 2;
  const Point left{-half_width * f.y, half_width * f.x};
  return {centre + ahead + left, centre + ahead - left, centre - ahead - left, centre - ahead + left};
}

// True when an axis of `box`, which is at the origin of the corners' frame, separates it from them.
bool OwnAxisSeparates(const OrientedBox& box, const Corners& corners) {
  const auto [x_low, x_high] = std::ranges::minmax(corners, {}, &Point::x);
  const auto [y_low, y_high] = std::ranges::minmax(corners, {}, &Point::y);
  return x_low.x > box.length / 2 || x_high.x < -box.length / 2 || y_low.y > box.width / 2 ||
         y_high.y < -box.width / 2;
}

// From the nearest corner to `box`, which is at the origin of the corners' frame.
double CornerDistance(const OrientedBox& box, const Corners& corners) {
  double nearest = 1e300;
  for (const Point p : corners) {
    nearest = std::min(nearest, std::hypot(std::max(std::abs(p.x) - box.length / 2, 0.0),
                                           std::max(std::abs(p.y) - box.width / 2, 0.0)));
  }
  return nearest;
}

double HalfDiagonal(const OrientedBox& box) { return std::hypot(box.length / 2, box.width / 2); }

}  // namespace

double BoxDistance(const OrientedBox& a, const OrientedBox& b) {
  const Corners b_in_a = LocalCorners(a.pose, b);
  const Corners a_in_b = LocalCorners(b.pose, a);
  if (!OwnAxisSeparates(a, b_in_a) && !OwnAxisSeparates(b, a_in_b)) return 0.0;
  // Two disjoint convex polygons are nearest at a corner of one of them.
  return std::min(CornerDistance(a, b_in_a), CornerDistance(b, a_in_b));
}

bool BoxesWithin(const OrientedBox& a, const OrientedBox& b, double clearance) {
  const Point offset = b.pose.position - a.pose.position;
  const double reach = HalfDiagonal(a) + HalfDiagonal(b) + clearance;
  return Dot(offset, offset) <= reach * reach && BoxDistance(a, b) <= clearance;
}

bool EgoTouchesAny(const WorldState& world) {
  const OrientedBox ego = EgoBox(world.ego.pose);
  return std::ranges::any_of(world.vehicles, [&](const SocialVehicle& vehicle) {
    return BoxesWithin(ego, vehicle.box(), kContactDistance);
  });
}

}  // namespace dadrl
