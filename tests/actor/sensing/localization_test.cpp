#include "actor/sensing/localization.h"

#include <gtest/gtest.h>

#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

TEST(Localizer, FindsLaneLimitAndRemainingRoute) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  Localizer localizer(map, route);
  const EgoLocation location = localizer.Locate({{35, 2.5}, 0.0});
  ASSERT_TRUE(location.nearest);
  EXPECT_EQ(location.nearest->lane, 1);
  EXPECT_NEAR(location.nearest->lateral, -0.7, 1e-9);
  EXPECT_EQ(location.lane_index, 1);
  EXPECT_DOUBLE_EQ(location.speed_limit, 10.0);
  EXPECT_NEAR(location.route_s, 25.0, 1e-9);
  EXPECT_NEAR(location.remaining, 0.75, 1e-9);
}

TEST(Localizer, OffTheLanesThereIsNoLimit) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  Localizer localizer(map, route);
  const EgoLocation near = localizer.Locate({{50, -5.0}, 0.0});
  EXPECT_TRUE(near.nearest);
  EXPECT_EQ(near.lane_index, -1);
  EXPECT_EQ(near.speed_limit, 0.0);
  EXPECT_FALSE(localizer.Locate({{50, -9.0}, 0.0}).nearest);
}

// A hairpin whose legs are 4 m apart: drifting to the middle must not jump onto the way back.
TEST(Localizer, DoesNotJumpAlongARouteThatComesNearItself) {
  std::vector<Lane> lanes;
  lanes.push_back(test::MakeLane("u_0", "u", 0, 10, {{0, 0}, {100, 0}, {100, 4}, {0, 4}}));
  const RoadMap map(std::move(lanes), {});
  const Route route(map, {0}, {0, 0}, {0, 4});
  Localizer localizer(map, route);
  EXPECT_NEAR(localizer.Locate({{10, 0}, 0.0}).route_s, 10.0, 1e-9);
  EXPECT_NEAR(localizer.Locate({{11, 2.3}, 0.0}).route_s, 11.0, 1e-9);
  localizer.Reset();
  EXPECT_NEAR(localizer.Locate({{11, 3.9}, 0.0}).route_s, 193.0, 1e-9);
}

}  // namespace
}  // namespace dadrl
