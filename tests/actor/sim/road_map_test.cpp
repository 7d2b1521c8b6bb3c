#include "actor/sim/road_map.h"

#include <gtest/gtest.h>

#include "common/util/random.h"

namespace dadrl {
namespace {

Lane MakeLane(std::string id, std::string edge, int index, std::vector<Point> points) {
  Lane lane;
  lane.id = std::move(id);
  lane.edge = std::move(edge);
  lane.index = index;
  lane.centre = Polyline(points);
  return lane;
}

// Two eastbound lanes and one westbound above them; each 100 m.
RoadMap ThreeLanes() {
  return RoadMap(
      {MakeLane("e_0", "e", 0, {{0, 0}, {100, 0}}), MakeLane("e_1", "e", 1, {{0, 3.2}, {100, 3.2}}),
       MakeLane("w_0", "w", 0, {{100, 6.4}, {0, 6.4}})},
      {});
}

TEST(RoadMap, FindsLanesById) {
  const RoadMap map = ThreeLanes();
  EXPECT_EQ(map.FindLane("w_0"), 2);
  EXPECT_EQ(map.FindLane("w_1"), -1);
}

TEST(RoadMap, NearestLaneGivesPlaceOnIt) {
  const RoadMap map = ThreeLanes();
  const auto position = map.NearestLane({42, 2.5}, 0.0, 5.0);
  ASSERT_TRUE(position.has_value());
  EXPECT_EQ(position->lane, 1);
  EXPECT_DOUBLE_EQ(position->s, 42.0);
  EXPECT_NEAR(position->lateral, -0.7, 1e-12);
  EXPECT_NEAR(position->distance, 0.7, 1e-12);
  EXPECT_DOUBLE_EQ(position->heading, 0.0);
}

TEST(RoadMap, NearestLaneRespectsRadius) {
  const RoadMap map = ThreeLanes();
  EXPECT_FALSE(map.NearestLane({50, -5}, 0.0, 4.9).has_value());
  EXPECT_TRUE(map.NearestLane({50, -5}, 0.0, 5.1).has_value());
  EXPECT_FALSE(map.NearestLane({1e6, 1e6}, 0.0, 5.0).has_value());
}

TEST(RoadMap, HeadingBreaksTies) {
  const RoadMap map = ThreeLanes();
  EXPECT_EQ(map.NearestLane({50, 4.8}, 0.0, 5.0)->lane, 1);
  EXPECT_EQ(map.NearestLane({50, 4.8}, std::numbers::pi, 5.0)->lane, 2);
}

TEST(RoadMap, GridAgreesWithAllLanes) {
  std::vector<Lane> lanes;
  Random random(7);
  for (int i = 0; i < 30; ++i) {
    std::vector<Point> points{{random.Uniform(-50, 50), random.Uniform(-50, 50)}};
    for (int k = 0; k < 5; ++k) {
      points.push_back(points.back() + Point{random.Uniform(-20, 20), random.Uniform(-20, 20)});
    }
    lanes.push_back(MakeLane(std::to_string(i), std::to_string(i), 0, points));
  }
  const RoadMap map(lanes, {});
  for (int i = 0; i < 1000; ++i) {
    const Point point{random.Uniform(-120, 120), random.Uniform(-120, 120)};
    double nearest = 1e9;
    for (const Lane& lane : lanes) nearest = std::min(nearest, lane.centre.Project(point).distance);
    const auto found = map.NearestLane(point, 0.0, 10.0);
    ASSERT_EQ(found.has_value(), nearest <= 10.0);
    if (found) {
      EXPECT_NEAR(found->distance, nearest, 0.011);
    }
    EXPECT_EQ(map.OffRoad(point), nearest > 1.7);
  }
}

TEST(RoadMap, OffRoadStartsATenthBeyondTheLaneEdge) {
  const RoadMap map = ThreeLanes();
  EXPECT_FALSE(map.OffRoad({50, -1.69}));
  EXPECT_TRUE(map.OffRoad({50, -1.71}));
  EXPECT_TRUE(map.OffRoad({102, 0}));
}

// A road under a bridge 7 m higher: where they cross, each has only itself.
TEST(RoadMap, RoadsAboveEachOtherAreKeptApart) {
  Lane bridge = MakeLane("over_0", "over", 0, {{50, -50}, {50, 50}});
  bridge.centre = Polyline(bridge.centre.points(), {7.0, 7.0});
  const RoadMap map({MakeLane("under_0", "under", 0, {{0, 0}, {100, 0}}), bridge}, {});
  EXPECT_TRUE(map.has_levels());
  EXPECT_EQ(map.NearestLane({50, 1}, 0.0, 5.0)->lane, 0);
  EXPECT_EQ(map.NearestLane({50, 1}, 0.0, 5.0, 7.0)->lane, 1);
  EXPECT_EQ(map.NearestLane({50, 1}, 0.0, 5.0, 7.0)->elevation, 7.0);
  EXPECT_FALSE(map.OffRoad({50, 20}, 7.0));
  EXPECT_TRUE(map.OffRoad({50, 20}, 0.0));
}

// Two villages 10,000 km apart: what the map takes follows the roads between them, of which there are none.
TEST(RoadMap, TakesWhatItsRoadsTakeNotItsExtent) {
  const RoadMap map(
      {MakeLane("a_0", "a", 0, {{0, 0}, {100, 0}}), MakeLane("b_0", "b", 0, {{1e7, 1e7}, {1e7 + 100, 1e7}})},
      {});
  EXPECT_EQ(map.NearestLane({50, 1}, 0.0, 5.0)->lane, 0);
  EXPECT_EQ(map.NearestLane({1e7 + 50, 1e7 + 1}, 0.0, 5.0)->lane, 1);
  EXPECT_TRUE(map.OffRoad({5e6, 5e6}));
}

TEST(RoadMap, AJunctionThatLeadsInACircleIsLeftAfterOneRound) {
  Lane in = MakeLane("in_0", "in", 0, {{0, 0}, {10, 0}});
  Lane first = MakeLane(":J_0_0", ":J_0", 0, {{10, 0}, {12, 0}});
  Lane second = MakeLane(":J_1_0", ":J_1", 0, {{12, 0}, {10, 0}});
  first.internal = second.internal = true;
  in.successors = {1};
  first.successors = {2};
  second.successors = {1, 3};
  const RoadMap map({in, first, second, MakeLane("out_0", "out", 0, {{10, 0}, {30, 0}})}, {});
  EXPECT_EQ(map.CrossingsFrom(0), (std::vector<std::vector<int>>{{1, 2, 3}}));
}

}  // namespace
}  // namespace dadrl
