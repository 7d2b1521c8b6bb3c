#include "actor/task/events.h"

#include <gtest/gtest.h>

#include <numbers>
#include <utility>
#include <vector>

#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

constexpr double kPi = std::numbers::pi;

class EventsTest : public testing::Test {
 protected:
  Events At(double x, double y, double heading = 0.0) {
    const WorldState world = test::WorldWithEgo(x, y, heading);
    localizer_.Reset();
    return detector_.Detect(world, localizer_.Locate(world.ego.pose));
  }

  RoadMap map_ = test::StraightRoad();
  Route route_ = test::StraightRoute(map_);
  Localizer localizer_{map_, route_};
  EventDetector detector_{map_, route_};
};

TEST_F(EventsTest, DrivingAlongTheRouteIsNoEvent) {
  const Events events = At(50, 0.3);
  EXPECT_FALSE(events.collision || events.off_road || events.goal || events.off_route || events.wrong_way);
}

TEST_F(EventsTest, OffRoadBeginsHalfALaneAndTenCentimetresFromTheOutermostLane) {
  EXPECT_FALSE(At(50, -1.69).off_road);
  EXPECT_TRUE(At(50, -1.71).off_road);
  EXPECT_FALSE(At(50, 6.4 + 1.69).off_road);
  EXPECT_TRUE(At(50, 6.4 + 1.71).off_road);
  EXPECT_TRUE(At(201.8, 0).off_road);  // past the dead end
}

TEST_F(EventsTest, GoalIsReachedWithinTwoMetresButNotInTheNextLane) {
  EXPECT_FALSE(At(107.99, 0).goal);
  EXPECT_TRUE(At(108.01, 0).goal);
  EXPECT_TRUE(At(111.9, 0).goal);
  EXPECT_FALSE(At(110, 3.2).goal);
}

TEST_F(EventsTest, WrongWayNeedsMoreThanNinetyDegrees) {
  EXPECT_FALSE(At(50, 0, kPi / 2 - 0.01).wrong_way);
  EXPECT_TRUE(At(50, 0, kPi / 2 + 0.01).wrong_way);
  EXPECT_TRUE(At(50, 6.4, 0.0).wrong_way);  // east in the lane that leads west
}

TEST_F(EventsTest, TheOtherLaneOfARouteEdgeAndItsOncomingPartnerAreOnRoute) {
  EXPECT_FALSE(At(50, 3.2).off_route);
  EXPECT_FALSE(At(50, 6.4, 0.0).off_route);
  EXPECT_FALSE(At(50, 6.4, kPi).off_route);
}

TEST_F(EventsTest, FarFromEveryLaneIsOffRoute) {
  EXPECT_FALSE(At(50, -6.9).off_route);
  EXPECT_TRUE(At(50, -7.1).off_route);
}

// route: in -> (junction) -> out; side leads through the junction into out; away leads nowhere.
TEST(EventDetector, ALaneThatLeadsIntoTheRouteIsOnRouteOnlyInItsDirection) {
  std::vector<Lane> lanes;
  lanes.push_back(test::MakeLane("in_0", "in", 0, 10, {{0, 0}, {50, 0}}, {1}));
  lanes.push_back(test::MakeLane(":j_0", ":j", 0, 10, {{50, 0}, {60, 0}}, {2}));
  lanes.push_back(test::MakeLane("out_0", "out", 0, 10, {{60, 0}, {100, 0}}));
  lanes.push_back(test::MakeLane("side_0", "side", 0, 10, {{55, -60}, {55, -10}}, {4}));
  lanes.push_back(test::MakeLane(":j_1", ":j", 0, 10, {{55, -10}, {57, -3}, {60, 0}}, {2}));
  lanes.push_back(test::MakeLane("away_0", "away", 0, 10, {{55, 10}, {55, 60}}));
  const RoadMap map(std::move(lanes), {});
  const Route route(map, {0, 1, 2}, {0, 0}, {100, 0});
  const EventDetector detector(map, route);
  Localizer localizer(map, route);
  const auto at = [&](double x, double y, double heading) {
    const WorldState world = test::WorldWithEgo(x, y, heading);
    localizer.Reset();
    return detector.Detect(world, localizer.Locate(world.ego.pose));
  };
  EXPECT_FALSE(at(55, -30, kPi / 2).off_route);
  EXPECT_TRUE(at(55, -30, -kPi / 2).off_route);
  EXPECT_TRUE(at(55, -30, -kPi / 2).wrong_way);
  EXPECT_TRUE(at(55, 30, kPi / 2).off_route);
  EXPECT_FALSE(at(56, -6, 0.0).off_route);  // in the junction
  EXPECT_FALSE(at(55, 0, kPi).wrong_way);   // junctions have no wrong way
}

}  // namespace
}  // namespace dadrl
