#include "actor/task/collision.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace dadrl {
namespace {

constexpr double kHalfLength = kVehicleLength / 2;
constexpr double kHalfWidth = kVehicleWidth / 2;
const double kDiagonal = 2 * std::hypot(kHalfLength, kHalfWidth);

using Corners = std::array<Point, 4>;

// Corners of `box` in the frame of `frame`.
Corners LocalCorners(const Pose& frame, const Pose& box) {
  const Point centre = ToLocal(frame, box.position);
  const Point f = Forward(box.heading - frame.heading);
  const Point ahead = kHalfLength * f;
  const Point left{-kHalfWidth * f.y, kHalfWidth * f.x};
  return {centre + ahead + left, centre + ahead - left, centre - ahead - left, centre - ahead + left};
}

// True when an axis of the box at the origin separates it from the corners.
bool OwnAxisSeparates(const Corners& corners) {
  const auto [x_low, x_high] = std::ranges::minmax(corners, {}, &Point::x);
  const auto [y_low, y_high] = std::ranges::minmax(corners, {}, &Point::y);
  return x_low.x > kHalfLength || x_high.x < -kHalfLength || y_low.y > kHalfWidth || y_high.y < -kHalfWidth;
}

// From the nearest corner to the box at the origin.
double CornerDistance(const Corners& corners) {
  double nearest = 1e300;
  for (const Point p : corners) {
    nearest = std::min(nearest, std::hypot(std::max(std::abs(p.x) - kHalfLength, 0.0),
                                           std::max(std::abs(p.y) - kHalfWidth, 0.0)));
  }
  return nearest;
}

}  // namespace

double BoxDistance(const Pose& a, const Pose& b) {
  const Corners b_in_a = LocalCorners(a, b);
  const Corners a_in_b = LocalCorners(b, a);
  if (!OwnAxisSeparates(b_in_a) && !OwnAxisSeparates(a_in_b)) return 0.0;
  // Two disjoint convex polygons are nearest at a corner of one of them.
  return std::min(CornerDistance(b_in_a), CornerDistance(a_in_b));
}

bool BoxesWithin(const Pose& a, const Pose& b, double clearance) {
  const Point offset = b.position - a.position;
  const double reach = kDiagonal + clearance;
  return Dot(offset, offset) <= reach * reach && BoxDistance(a, b) <= clearance;
}

bool EgoTouchesAny(const WorldState& world) {
  return std::ranges::any_of(world.vehicles, [&](const SocialVehicle& vehicle) {
    return BoxesWithin(world.ego.pose, vehicle.pose, kContactDistance);
  });
}

}  // namespace dadrl
