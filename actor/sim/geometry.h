// Planar geometry of the driving task. Metres and radians; heading 0 is east (+x), counter-clockwise
// positive.
#pragma once

#include <cmath>
#include <numbers>

namespace dadrl {

struct Point {
  double x = 0.0;
  double y = 0.0;
};

inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(double s, Point p) { return {s * p.x, s * p.y}; }
inline double Dot(Point a, Point b) { return a.x * b.x + a.y * b.y; }
inline double Cross(Point a, Point b) { return a.x * b.y - a.y * b.x; }
inline double Norm(Point p) { return std::hypot(p.x, p.y); }

// Position and direction of a box's centre.
struct Pose {
  Point position;
  double heading = 0.0;
};

// A rectangle on the ground.
struct OrientedBox {
  Pose pose;  // of its centre
  double length = 0.0;
  double width = 0.0;
};

inline Point Forward(double heading) { return {std::cos(heading), std::sin(heading)}; }

// Whether two things so far apart, in height and on the ground, in metres, can be on one road: roads on two
// levels are more than 2.5 m apart where they cross, and no road is steeper than 8 %.
inline bool OnOneLevel(double elevation_difference, double distance) {
  return std::abs(elevation_difference) <= 2.5 + 0.08 * distance;
}

// Into (-pi, pi].
inline double WrapAngle(double angle) {
  if (angle > -std::numbers::pi && angle <= std::numbers::pi) return angle;
  const double wrapped = std::remainder(angle, 2.0 * std::numbers::pi);
  return wrapped <= -std::numbers::pi ? wrapped + 2.0 * std::numbers::pi : wrapped;
}

// A pose to look at many points from.
struct LocalFrame {
  explicit LocalFrame(const Pose& at) : pose(at), forward(Forward(at.heading)) {}

  // `point` of the world: x ahead, y to the left.
  Point ToLocal(Point point) const {
    const Point d = point - pose.position;
    return {Dot(d, forward), Cross(forward, d)};
  }

  Pose pose;
  Point forward;
};

inline Point ToLocal(const Pose& pose, Point point) { return LocalFrame(pose).ToLocal(point); }

}  // namespace dadrl
