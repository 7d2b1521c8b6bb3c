#include "actor/sim/route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Lane MakeLane(std::string id, std::string edge, int index, std::vector<Point> points,
              std::vector<int> successors = {}) {
  Lane lane;
  lane.internal = id[0] == ':';
  lane.id = std::move(id);
  lane.edge = std::move(edge);
  lane.index = index;
  lane.centre = Polyline(points);
  lane.successors = std::move(successors);
  return lane;
}

// a (two lanes) -> junction, split in two pieces -> b (two lanes); c leaves from a's right lane.
RoadMap Road() {
  return RoadMap(
      {MakeLane("a_0", "a", 0, {{0, 0}, {60, 0}}, {2, 7}),
       MakeLane("a_1", "a", 1, {{0, 3.2}, {60, 3.2}}, {4}),
       MakeLane(":J_0_0", ":J_0", 0, {{60, 0}, {65, 0}}, {3}),
       MakeLane(":J_1_0", ":J_1", 0, {{65, 0}, {70, 0}}, {5}),
       MakeLane(":J_2_0", ":J_2", 0, {{60, 3.2}, {70, 3.2}}, {6}),
       MakeLane("b_0", "b", 0, {{70, 0}, {120, 0}}), MakeLane("b_1", "b", 1, {{70, 3.2}, {120, 3.2}}),
       MakeLane(":J_3_0", ":J_3", 0, {{60, 0}, {60, -10}}, {8}),
       MakeLane("c_0", "c", 0, {{60, -10}, {60, -40}})},
      {});
}

TEST(ConnectLanes, FillsInTheLanesInsideJunctions) {
  EXPECT_THAT(ConnectLanes(Road(), {"a_0", "b_0"}).value(), ElementsAre(0, 2, 3, 5));
  EXPECT_THAT(ConnectLanes(Road(), {"a_1", "a_0", "b_0"}).value(), ElementsAre(1, 0, 2, 3, 5));
}

TEST(ConnectLanes, NamesWhatIsMissing) {
  EXPECT_THAT(ConnectLanes(Road(), {"a_0", "x_0"}).error().message, HasSubstr("'x_0'"));
  EXPECT_THAT(ConnectLanes(Road(), {"a_1", "c_0"}).error().message,
              HasSubstr("from lane 'a_1' to lane 'c_0'"));
  EXPECT_EQ(ConnectLanes(Road(), {}).error().code, ErrorCode::kInvalidArgument);
}

TEST(Route, RunsFromStartToGoal) {
  const RoadMap map = Road();
  const Route route(map, {0, 2, 3, 5}, {10, 0}, {110, 0});
  EXPECT_DOUBLE_EQ(route.length(), 100.0);
  EXPECT_DOUBLE_EQ(route.goal().x, 110.0);
  EXPECT_DOUBLE_EQ(route.Progress({35, 1}), 0.25);
  EXPECT_DOUBLE_EQ(route.Progress({0, 0}), 0.0);
  EXPECT_DOUBLE_EQ(route.Progress({200, 0}), 1.0);
}

TEST(Route, ChangesLanesSmoothly) {
  const RoadMap map = Road();
  const Route route(map, {1, 0, 2, 3, 5}, {10, 3.2}, {110, 0});
  EXPECT_NEAR(route.length(), 100.4, 0.2);
  EXPECT_NEAR(route.centre().At(15.0).y, 1.6, 0.1);
  EXPECT_NEAR(route.centre().At(40.0).y, 0.0, 1e-9);
  for (double s = 0; s < 99; s += 1.0) {
    EXPECT_LT(std::abs(WrapAngle(route.centre().HeadingAt(s + 1.0) - route.centre().HeadingAt(s))), 0.05);
  }
}

TEST(Route, KnowsItsEdgesAndTheLanesBetweenThem) {
  const RoadMap map = Road();
  const Route route(map, {0, 2, 3, 5}, {10, 0}, {110, 0});
  for (const int lane : {0, 1, 2, 3, 4, 5, 6}) EXPECT_TRUE(route.OnRoute(lane)) << lane;
  for (const int lane : {7, 8, -1, 99}) EXPECT_FALSE(route.OnRoute(lane)) << lane;
}

}  // namespace
}  // namespace dadrl
