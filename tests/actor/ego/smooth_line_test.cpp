#include "actor/ego/smooth_line.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dadrl {
namespace {

TEST(SmoothLine, PassesThroughEveryPoint) {
  const Polyline line({{0, 0}, {40, 0}, {43, 1}, {44, 4}, {44, 50}});
  const Polyline smooth = SmoothLine(line);
  for (const Point& point : line.points()) EXPECT_LT(smooth.Project(point).distance, 1e-9);
  EXPECT_NEAR(smooth.length(), line.length(), 1.0);
}

TEST(SmoothLine, LeavesStraightsStraight) {
  const Polyline smooth = SmoothLine(Polyline({{0, 0}, {40, 0}, {43, 1}, {44, 4}, {44, 50}}));
  for (double s = 0.0; s < 36.0; s += 0.25) EXPECT_NEAR(smooth.At(s).y, 0.0, 1e-9);
  for (const Point& point : smooth.points()) EXPECT_GT(point.y, -0.3);
  EXPECT_NEAR(SmoothLine(Polyline({{0, 0}, {3, 4}})).length(), 5.0, 1e-9);
}

TEST(SmoothLine, TurnsAPolygonIntoItsCircle) {
  std::vector<Point> points;
  for (int i = 0; i <= 20; ++i) points.push_back({50 * std::cos(0.15 * i), 50 * std::sin(0.15 * i)});
  const Polyline smooth = SmoothLine(Polyline(points));
  for (double s = 10.0; s < smooth.length() - 10.0; s += 0.1) {
    EXPECT_NEAR(Norm(smooth.At(s)), 50.0, 0.02);
  }
}

}  // namespace
}  // namespace dadrl
