#include "actor/task/collision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "common/util/random.h"
#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;
const Pose kEgo{{0, 0}, 0.0};

// 3.68 x 1.47: bumper to bumper the centres are 3.68 apart, side to side 1.47, across 1.84 + 0.735 = 2.575.
TEST(BoxDistance, ParallelAndCrossedBoxesMatchArithmetic) {
  EXPECT_NEAR(BoxDistance(kEgo, {{5.0, 0}, 0.0}), 5.0 - 3.68, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, {{5.0, 1.0}, std::numbers::pi}), 5.0 - 3.68, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, {{1.0, 2.0}, 0.0}), 2.0 - 1.47, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, {{4.0, 0}, kQuarter}), 4.0 - 2.575, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, {{3.68 + 3.0, 1.47 + 4.0}, 0.0}), 5.0, 1e-12);
}

TEST(BoxDistance, ACornerPointingAtASideIsMeasuredToTheSide) {
  // A box turned by 45 degrees above the ego: its lowest corner is (1.84 + 0.735) / sqrt(2) under its centre.
  const double reach = (1.84 + 0.735) / std::numbers::sqrt2;
  EXPECT_NEAR(BoxDistance(kEgo, {{0.2, 4.0}, std::numbers::pi / 4}), 4.0 - reach - 0.735, 1e-12);
}

TEST(BoxDistance, BoxesCrossingWithoutCornersInsideOverlap) {
  EXPECT_EQ(BoxDistance(kEgo, {{0, 0}, kQuarter}), 0.0);
  EXPECT_EQ(BoxDistance(kEgo, {{0.3, 0.2}, 1.0}), 0.0);
  EXPECT_EQ(BoxDistance(kEgo, kEgo), 0.0);
}

TEST(BoxDistance, IsSymmetricAndAgreesWithSampledOutlines) {
  Random random(3);
  const auto outline = [](const Pose& box, int i) {
    constexpr int kSide = 200;
    const double t = 2.0 * (i % kSide) / kSide - 1.0;
    const double sign = i / kSide % 2 == 0 ? 1.0 : -1.0;
    const Point local = i < 2 * kSide ? Point{sign * 1.84, t * 0.735} : Point{t * 1.84, sign * 0.735};
    return test::Moved(local, box.heading, box.position);
  };
  for (int trial = 0; trial < 15; ++trial) {
    const Pose a{{random.Uniform(-3, 3), random.Uniform(-3, 3)}, random.Uniform(-4, 4)};
    const Pose b{{random.Uniform(-3, 3), random.Uniform(-3, 3)}, random.Uniform(-4, 4)};
    const double distance = BoxDistance(a, b);
    EXPECT_NEAR(distance, BoxDistance(b, a), 1e-12);
    if (distance == 0.0) continue;
    double sampled = 1e9;
    for (int i = 0; i < 800; ++i) {
      for (int j = 0; j < 800; ++j) sampled = std::min(sampled, Norm(outline(a, i) - outline(b, j)));
    }
    EXPECT_LE(distance, sampled + 1e-9);
    EXPECT_GE(distance, sampled - 0.05);
  }
}

TEST(EgoTouchesAny, FiveCentimetresDecide) {
  WorldState world = test::WorldWithEgo(10, 5, 0.3);
  const Point ahead = Forward(0.3);
  const auto place = [&](double gap) {
    const Point p = world.ego.pose.position + (3.68 + gap) * ahead;
    world.vehicles = {test::Vehicle(1, 500, 500), test::Vehicle(0, p.x, p.y, 0.3)};
    return EgoTouchesAny(world);
  };
  EXPECT_TRUE(place(0.049));
  EXPECT_FALSE(place(0.051));
  EXPECT_TRUE(place(-1.0));
  world.vehicles.clear();
  EXPECT_FALSE(EgoTouchesAny(world));
}

}  // namespace
}  // namespace dadrl
