#include "actor/sim/polyline.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "common/util/random.h"

namespace dadrl {
namespace {

const Polyline kCorner({{0, 0}, {10, 0}, {10, 5}});

TEST(Polyline, MeasuresAlongItsLength) {
  EXPECT_DOUBLE_EQ(kCorner.length(), 15.0);
  EXPECT_DOUBLE_EQ(kCorner.At(12.0).x, 10.0);
  EXPECT_DOUBLE_EQ(kCorner.At(12.0).y, 2.0);
  EXPECT_DOUBLE_EQ(kCorner.HeadingAt(3.0), 0.0);
  EXPECT_DOUBLE_EQ(kCorner.HeadingAt(12.0), std::numbers::pi / 2);
}

TEST(Polyline, ContinuesStraightBeyondItsEnds) {
  EXPECT_DOUBLE_EQ(kCorner.At(-2.0).x, -2.0);
  EXPECT_DOUBLE_EQ(kCorner.At(18.0).y, 8.0);
  EXPECT_DOUBLE_EQ(kCorner.HeadingAt(18.0), std::numbers::pi / 2);
}

TEST(Polyline, DropsRepeatedPoints) {
  const Polyline line({{0, 0}, {0, 0}, {4, 0}, {4, 0.0005}});
  EXPECT_EQ(line.points().size(), 2u);
  EXPECT_DOUBLE_EQ(line.length(), 4.0);
}

TEST(Polyline, ProjectsWithSignedSide) {
  const auto left = kCorner.Project({4, 1.5});
  EXPECT_DOUBLE_EQ(left.s, 4.0);
  EXPECT_DOUBLE_EQ(left.lateral, 1.5);
  const auto right = kCorner.Project({12, 3});
  EXPECT_DOUBLE_EQ(right.s, 13.0);
  EXPECT_DOUBLE_EQ(right.lateral, -2.0);
  const auto before = kCorner.Project({-3, 4});
  EXPECT_DOUBLE_EQ(before.s, 0.0);
  EXPECT_DOUBLE_EQ(before.distance, 5.0);
}

TEST(Polyline, WindowKeepsTheProjectionOnItsBranch) {
  const Polyline hairpin({{0, 0}, {20, 0}, {20, 2}, {0, 2}});
  const Point near_both{5, 1.2};
  EXPECT_DOUBLE_EQ(hairpin.Project(near_both).s, 37.0);
  EXPECT_DOUBLE_EQ(hairpin.Project(near_both, 0, 10).s, 5.0);
  EXPECT_DOUBLE_EQ(hairpin.Project(near_both, 6, 10).s, 6.0);
  EXPECT_DOUBLE_EQ(hairpin.Project(near_both, 30, 36).s, 36.0);
}

TEST(Polyline, ProjectionOfALongLineIsTheNearestOfItsSegments) {
  Random random(3);
  std::vector<Point> points{{0, 0}};
  for (int i = 0; i < 200; ++i)
    points.push_back(points.back() + Point{random.Uniform(-2, 3), random.Uniform(-2, 2)});
  const Polyline line(points);
  for (int i = 0; i < 500; ++i) {
    const Point point{random.Uniform(-20, 120), random.Uniform(-40, 40)};
    const double low = i % 2 == 0 ? 0.0 : random.Uniform(0, 300);
    const double high = i % 2 == 0 ? line.length() : low + random.Uniform(0, 100);
    double nearest = 1e9;
    for (size_t k = 0; k + 1 < line.points().size(); ++k) {
      const double from = std::max(low, line.arc()[k]);
      const double to = std::min(high, line.arc()[k + 1]);
      if (from > to) continue;
      const Point direction = Forward(line.HeadingAt(0.5 * (line.arc()[k] + line.arc()[k + 1])));
      const double along =
          std::clamp(Dot(point - line.points()[k], direction), from - line.arc()[k], to - line.arc()[k]);
      nearest = std::min(nearest, Norm(point - (line.points()[k] + along * direction)));
    }
    const auto projection = line.Project(point, low, high);
    EXPECT_NEAR(projection.distance, nearest, 1e-9);
    EXPECT_NEAR(Norm(line.At(projection.s) - point), nearest, 1e-9);
    EXPECT_NEAR(std::abs(projection.lateral), nearest, 1e-9);
  }
}

}  // namespace
}  // namespace dadrl
