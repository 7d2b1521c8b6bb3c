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
const OrientedBox kEgo = EgoBox({{0, 0}, 0.0});

OrientedBox At(double x, double y, double heading) { return EgoBox({{x, y}, heading}); }

// 3.68 x 1.47: bumper to bumper the centres are 3.68 apart, side to side 1.47, across 1.84 + 0.735 = 2.575.
TEST(BoxDistance, ParallelAndCrossedBoxesMatchArithmetic) {
  EXPECT_NEAR(BoxDistance(kEgo, At(5.0, 0, 0.0)), 5.0 - 3.68, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, At(5.0, 1.0, std::numbers::pi)), 5.0 - 3.68, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, At(1.0, 2.0, 0.0)), 2.0 - 1.47, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, At(4.0, 0, kQuarter)), 4.0 - 2.575, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, At(3.68 + 3.0, 1.47 + 4.0, 0.0)), 5.0, 1e-12);
}

TEST(BoxDistance, ACornerPointingAtASideIsMeasuredToTheSide) {
  // A box turned by 45 degrees above the ego: its lowest corner is (1.84 + 0.735) / sqrt(2) under its centre.
  const double reach = (1.84 + 0.735) / std::numbers::sqrt2;
  EXPECT_NEAR(BoxDistance(kEgo, At(0.2, 4.0, std::numbers::pi / 4)), 4.0 - reach - 0.735, 1e-12);
}

TEST(BoxDistance, BoxesCrossingWithoutCornersInsideOverlap) {
  EXPECT_EQ(BoxDistance(kEgo, At(0, 0, kQuarter)), 0.0);
  EXPECT_EQ(BoxDistance(kEgo, At(0.3, 0.2, 1.0)), 0.0);
  EXPECT_EQ(BoxDistance(kEgo, kEgo), 0.0);
}

// 16.5 x 2.5 beside 3.68 x 1.47: bumper to bumper 10.09 between the centres, side to side 1.985.
TEST(BoxDistance, ALorryReachesAsFarAsItIsLongAndWide) {
  const OrientedBox lorry{{{20.0, 0}, std::numbers::pi}, 16.5, 2.5};
  EXPECT_NEAR(BoxDistance(kEgo, lorry), 20.0 - 10.09, 1e-12);
  EXPECT_NEAR(BoxDistance(kEgo, {{{5.0, 3.0}, 0.0}, 16.5, 2.5}), 3.0 - 1.985, 1e-12);
  EXPECT_TRUE(BoxesWithin(kEgo, {{{10.0, 0}, 0.0}, 16.5, 2.5}, 0.0));
}

TEST(BoxDistance, IsSymmetricAndAgreesWithSampledOutlines) {
  Random random(3);
  const auto outline = [](const OrientedBox& box, int i) {
    constexpr int kSide = 200;
    const double t = 2.0 * (i % kSide) / kSide - 1.0;
    const double sign = i / kSide % 2 == 0 ? 1.0 : -1.0;
    const Point unit = i < 2 * kSide ? Point{sign, t} : Point{t, sign};
    return test::Moved({unit.x * box.length / 2, unit.y * box.width / 2}, box.pose.heading,
                       box.pose.position);
  };
  const auto draw = [&] {
    const Pose pose{{random.Uniform(-3, 3), random.Uniform(-3, 3)}, random.Uniform(-4, 4)};
    return OrientedBox{pose, random.Uniform(1, 5), random.Uniform(0.5, 2)};
  };
  for (int trial = 0; trial < 15; ++trial) {
    const OrientedBox a = draw();
    const OrientedBox b = draw();
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
