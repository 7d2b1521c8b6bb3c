#include "actor/sensing/polylines.h"

#include <gtest/gtest.h>

#include <numbers>

#include "actor/sensing/sensor.h"
#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

// A road east that forks after 50 m: to the left (north) at once, or straight on for 14 m.
RoadMap Fork() {
  std::vector<Lane> lanes;
  lanes.push_back(test::MakeLane("in_0", "in", 0, 10.0, {{0, 0}, {50, 0}}, {1, 2}));
  lanes.push_back(test::MakeLane(":J_0_0", ":J_0", 0, 10.0, {{50, 0}, {50, 10}}, {3}));
  lanes.push_back(test::MakeLane(":J_1_0", ":J_1", 0, 10.0, {{50, 0}, {60, 0}}, {4}));
  lanes.push_back(test::MakeLane("left_0", "left", 0, 10.0, {{50, 10}, {50, 60}}));
  lanes.push_back(test::MakeLane("on_0", "on", 0, 10.0, {{60, 0}, {64, 0}}));
  return RoadMap(std::move(lanes), {});
}

class PolylinesTest : public testing::Test {
 protected:
  // Feature `f` of point `i` of `way`.
  float At(int way, int i, int f) const { return out_[static_cast<size_t>((way * 10 + i) * 5 + f)]; }
  bool Absent(int way, int i) const {
    for (int f = 1; f < 5; ++f) EXPECT_TRUE(At(way, i, 0) == 0.0f || At(way, i, f) == 0.0f);
    return At(way, i, 0) == 1.0f;
  }
  void ExpectPoint(int way, int i, double x, double y) const {
    EXPECT_FALSE(Absent(way, i)) << way << ", " << i;
    EXPECT_NEAR(At(way, i, 1), x / 30.0, 1e-6) << way << ", " << i;
    EXPECT_NEAR(At(way, i, 2), y / 30.0, 1e-6) << way << ", " << i;
  }

  std::vector<float> out_ = std::vector<float>(2 * 10 * 5, 9.0f);
};

TEST_F(PolylinesTest, AVehicleBeforeAForkHasBothBranchesStraightestFirst) {
  const RoadMap map = Fork();
  const Route route(map, {0, 2, 4}, {0, 0}, {64, 0});
  const WorldState world = test::WorldWithEgo(30, 0);
  Polylines(map, route).WriteVehicle(world.ego, test::Vehicle(1, 48, 0), out_);
  for (int i = 0; i < 10; ++i) ExpectPoint(0, i, 19 + i, 0);
  for (int i = 0; i < 2; ++i) ExpectPoint(1, i, 19 + i, 0);
  for (int i = 2; i < 10; ++i) ExpectPoint(1, i, 20, i - 1);
}

TEST_F(PolylinesTest, ARoadThatEndsLeavesPointsAbsent) {
  const RoadMap map = Fork();
  const Route route(map, {0, 2, 4}, {0, 0}, {64, 0});
  const WorldState world = test::WorldWithEgo(61, 0);
  Polylines(map, route).WriteEgo(world.ego, 61.0, out_);
  for (int way = 0; way < 2; ++way) {
    for (int i = 0; i < 3; ++i) ExpectPoint(way, i, i + 1, 0);
    for (int i = 3; i < 10; ++i) EXPECT_TRUE(Absent(way, i)) << way << ", " << i;
  }
}

TEST_F(PolylinesTest, WithoutAForkTheSecondWayIsTheLaneBeside) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  // The ego faces north: east is to its right.
  const WorldState world = test::WorldWithEgo(20, 0, std::numbers::pi / 2);
  Polylines(map, route).WriteVehicle(world.ego, test::Vehicle(1, 40, 0.3), out_);
  ExpectPoint(0, 0, 0.0, -21);
  ExpectPoint(0, 9, 0.0, -30);
  ExpectPoint(1, 0, 3.2, -21);
  EXPECT_NEAR(At(0, 0, 3), 0.0, 1e-6) << "cos of a right turn";
  EXPECT_NEAR(At(0, 0, 4), -1.0, 1e-6) << "sin of it";
  Polylines(map, route).WriteVehicle(world.ego, test::Vehicle(1, 40, 3.2), out_);
  ExpectPoint(1, 0, 0.0, -21);
  Polylines(map, route).WriteVehicle(world.ego, test::Vehicle(1, 40, 6.4, std::numbers::pi), out_);
  ExpectPoint(0, 0, 6.4, -19);
  EXPECT_TRUE(Absent(1, 0)) << "a road of one lane";
}

TEST_F(PolylinesTest, OffTheRoadThereAreNoWaysButTheEgosRoute) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  const WorldState world = test::WorldWithEgo(20, -30);
  Polylines(map, route).WriteVehicle(world.ego, test::Vehicle(1, 40, -30), out_);
  for (int way = 0; way < 2; ++way) EXPECT_TRUE(Absent(way, 0));
  Polylines(map, route).WriteEgo(world.ego, 10.0, out_);
  ExpectPoint(0, 0, 1, 30);
  EXPECT_TRUE(Absent(1, 0));
}

TEST_F(PolylinesTest, TheColumnIsThereOnlyWhereItIsAskedFor) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  ObservationConfig config;
  EXPECT_EQ(StepSpec(DrivingShape::From(config)).observation.size(), 3u);
  config.polylines = true;
  config.vehicles = 2;
  const DrivingShape shape = DrivingShape::From(config);
  Sensor sensor(map, route, config);
  WorldState world = test::WorldWithEgo(20, 0);
  world.vehicles = {test::Vehicle(7, 30, 3.2)};
  Localizer localizer(map, route);
  sensor.Update(world, localizer.Locate(world.ego.pose));
  Observation observation{StepSpec(shape)};
  sensor.Observe(observation);
  const std::span<float> ways = observation.floats(shape.polylines_column);
  ASSERT_EQ(ways.size(), 6u * 10u * 5u);
  EXPECT_NEAR(ways[1], 1.0 / 30, 1e-6) << "the ego's route";
  EXPECT_NEAR(ways[2 * 50 + 1], 11.0 / 30, 1e-6) << "the vehicle's lane";
  EXPECT_EQ(ways[4 * 50], 1.0f) << "no second vehicle";
}

}  // namespace
}  // namespace dadrl
