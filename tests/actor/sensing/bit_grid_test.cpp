#include "actor/sensing/bit_grid.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "common/util/random.h"

namespace dadrl {
namespace {

int Count(const BitGrid& grid) {
  int count = 0;
  for (int row = 0; row < grid.height(); ++row) {
    for (int column = 0; column < grid.width(); ++column) count += grid.Get(row, column) ? 1 : 0;
  }
  return count;
}

double SegmentDistance(Point p, Point a, Point b) {
  const Point ab = b - a;
  const double t = Dot(ab, ab) > 0 ? std::clamp(Dot(p - a, ab) / Dot(ab, ab), 0.0, 1.0) : 0.0;
  return Norm(p - (a + t * ab));
}

TEST(BitGrid, RectangleSetsExactlyTheCellsWhoseCentreItHolds) {
  BitGrid grid(100, 20);
  const std::vector<Point> rectangle = {{10.4, 3.6}, {80.4, 3.6}, {80.4, 7.4}, {10.4, 7.4}};
  grid.FillPolygon(rectangle);
  EXPECT_EQ(Count(grid), 70 * 3);  // centres 10.5 ... 79.5 by 4.5 ... 6.5
  EXPECT_TRUE(grid.Get(4, 10));
  EXPECT_TRUE(grid.Get(6, 79));
  EXPECT_FALSE(grid.Get(3, 10));
  EXPECT_FALSE(grid.Get(4, 80));
}

TEST(BitGrid, ConcavePolygonLeavesItsNotchOpen) {
  BitGrid grid(20, 20);
  const std::vector<Point> u = {{2, 2}, {18, 2}, {18, 18}, {12, 18}, {12, 8}, {8, 8}, {8, 18}, {2, 18}};
  grid.FillPolygon(u);
  EXPECT_TRUE(grid.Get(15, 4));
  EXPECT_TRUE(grid.Get(15, 14));
  EXPECT_FALSE(grid.Get(15, 10));
  EXPECT_EQ(Count(grid), 16 * 16 - 4 * 10);
}

TEST(BitGrid, RoundStripIsTheSetOfPointsNearTheSegment) {
  Random random(7);
  for (int trial = 0; trial < 200; ++trial) {
    BitGrid grid(70, 50);
    const Point a{random.Uniform(-20, 90), random.Uniform(-20, 70)};
    const Point b = trial % 7 == 0 ? a : Point{random.Uniform(-20, 90), random.Uniform(-20, 70)};
    const double radius = random.Uniform(0.3, 9);
    grid.FillStrip(a, b, radius, BitGrid::Ends::kRound);
    for (int row = 0; row < grid.height(); ++row) {
      for (int column = 0; column < grid.width(); ++column) {
        const double distance = SegmentDistance({column + 0.5, row + 0.5}, a, b);
        if (std::abs(distance - radius) < 1e-9) continue;
        ASSERT_EQ(grid.Get(row, column), distance < radius)
            << "trial " << trial << " row " << row << " column " << column << " distance " << distance;
      }
    }
  }
}

TEST(BitGrid, SquareStripEndsAtItsEnds) {
  BitGrid grid(40, 40);
  grid.FillStrip({10, 20}, {30, 20}, 3, BitGrid::Ends::kSquare);
  EXPECT_EQ(Count(grid), 20 * 6);
  EXPECT_FALSE(grid.Get(20, 9));
  EXPECT_FALSE(grid.Get(20, 30));
  grid.Clear();
  grid.FillStrip({20, 30}, {20, 10}, 3, BitGrid::Ends::kSquare);
  EXPECT_EQ(Count(grid), 20 * 6);
}

TEST(BitGrid, WhatLiesOutsideIsCutOff) {
  BitGrid grid(64, 8);
  grid.FillStrip({-1e6, 4}, {1e6, 4}, 100, BitGrid::Ends::kRound);
  EXPECT_EQ(Count(grid), 64 * 8);
  grid.Clear();
  grid.FillStrip({-50, -50}, {-40, -45}, 3, BitGrid::Ends::kRound);
  grid.FillStrip({100, 3}, {120, 3}, 3, BitGrid::Ends::kRound);
  EXPECT_EQ(Count(grid), 0);
}

}  // namespace
}  // namespace dadrl
