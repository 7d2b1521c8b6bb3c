#include "actor/task/collision_report.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

constexpr double kQuarter = std::numbers::pi / 2;

// The ego at (50, y) heading east at 8 m/s, one other vehicle.
class DescribeCollisionTest : public testing::Test {
 protected:
  std::optional<CollisionSummary> Describe(const SocialVehicle& other, double y = 0.0, double turn = 0.0) {
    WorldState world = test::WorldWithEgo(50, y, turn, 8.0);
    world.vehicles = {test::Vehicle(7, 500, 500), other};
    Localizer localizer(map_, route_);
    return DescribeCollision(world, localizer.Locate(world.ego.pose), map_);
  }

  RoadMap map_ = test::StraightRoad();
  Route route_ = test::StraightRoute(map_);
};

TEST_F(DescribeCollisionTest, NothingTouchedIsNoCollision) {
  EXPECT_FALSE(Describe(test::Vehicle(0, 55, 0)));
}

TEST_F(DescribeCollisionTest, TheCarAheadIsRunInto) {
  const auto collision = Describe(test::Vehicle(0, 53.6, 0.1, 0.0, 2.0));
  ASSERT_TRUE(collision);
  EXPECT_EQ(collision->side, ContactSide::kFront);
  EXPECT_EQ(collision->ego_speed_mps, 8.0);
  EXPECT_EQ(collision->other_speed_mps, 2.0);
  EXPECT_EQ(collision->lane_changer, LaneChanger::kNobody);
  EXPECT_FALSE(collision->junction);
  EXPECT_EQ(CollisionKind(*collision), "ran_into");
}

TEST_F(DescribeCollisionTest, ContactWithoutOverlapHasASideToo) {
  EXPECT_EQ(Describe(test::Vehicle(0, 53.68 + 0.04, 0))->side, ContactSide::kFront);
  EXPECT_EQ(Describe(test::Vehicle(0, 50 - 3.68 - 0.04, 0.2))->side, ContactSide::kRear);
  EXPECT_EQ(Describe(test::Vehicle(0, 50, 1.47 + 0.04))->side, ContactSide::kLeft);
  EXPECT_EQ(Describe(test::Vehicle(0, 50, -1.47 - 0.04))->side, ContactSide::kRight);
}

// A crossing car from the right, its nose 0.3 m inside the ego's right door.
TEST_F(DescribeCollisionTest, ACrossingCarHitsTheSideThatItCameFrom) {
  const auto collision = Describe(test::Vehicle(0, 50.5, -0.735 - 1.84 + 0.3, kQuarter, 10.0));
  ASSERT_TRUE(collision);
  EXPECT_EQ(collision->side, ContactSide::kRight);
  EXPECT_NEAR(collision->relative_heading_rad, kQuarter, 1e-12);
  EXPECT_EQ(CollisionKind(*collision), "crossing");
}

// The ego's nose 0.3 m inside the left flank of a car that crosses to the left.
TEST_F(DescribeCollisionTest, DrivingIntoACrossingCarIsAFrontHit) {
  const auto collision = Describe(test::Vehicle(0, 50 + 1.84 + 0.735 - 0.3, 0.4, kQuarter, 10.0));
  ASSERT_TRUE(collision);
  EXPECT_EQ(collision->side, ContactSide::kFront);
  EXPECT_EQ(CollisionKind(*collision), "crossing");
}

TEST_F(DescribeCollisionTest, OfSeveralTheNearestCounts) {
  WorldState world = test::WorldWithEgo(50, 0, 0, 8);
  world.vehicles = {test::Vehicle(0, 53.6, 0, 0, 1.0), test::Vehicle(1, 47.0, 0, 0, 9.0)};
  Localizer localizer(map_, route_);
  const auto collision = DescribeCollision(world, localizer.Locate(world.ego.pose), map_);
  EXPECT_EQ(collision->other_speed_mps, 9.0);
  EXPECT_EQ(collision->side, ContactSide::kRear);
  EXPECT_EQ(CollisionKind(*collision), "rear_ended");
}

// Lanes lie on y = 0 and y = 3.2: 0.6 is out of the first, 2.7 is just within 0.5 m of the second.
TEST_F(DescribeCollisionTest, WhoIsBetweenLanesIsChangingThem) {
  const auto changer = [&](double ego_y, double other_y) {
    return Describe(test::Vehicle(0, 51, other_y), ego_y)->lane_changer;
  };
  EXPECT_EQ(changer(0.0, 1.3), LaneChanger::kOther);
  EXPECT_EQ(changer(0.6, 0.1), LaneChanger::kEgo);
  EXPECT_EQ(changer(0.6, 1.9), LaneChanger::kBoth);
  EXPECT_EQ(changer(2.75, 3.2), LaneChanger::kNobody);
  EXPECT_EQ(CollisionKind(*Describe(test::Vehicle(0, 51, 1.3))), "lane_change");
}

TEST_F(DescribeCollisionTest, InsideAJunctionNobodyChangesLanes) {
  const RoadMap junction({test::MakeLane(":j_0_0", ":j_0", 0, 10.0, {{0, 0}, {200, 0}})}, {});
  WorldState world = test::WorldWithEgo(50, 0.8, 0, 8);
  world.vehicles = {test::Vehicle(0, 52, 0.9)};
  EgoLocation location;
  location.nearest = junction.NearestLane(world.ego.pose.position, 0.0, kLaneSearchRadius);
  const auto collision = DescribeCollision(world, location, junction);
  EXPECT_TRUE(collision->junction);
  EXPECT_EQ(collision->lane_changer, LaneChanger::kNobody);
}

}  // namespace
}  // namespace dadrl
