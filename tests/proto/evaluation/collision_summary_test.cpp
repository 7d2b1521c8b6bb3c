#include "proto/evaluation/collision_summary.h"

#include <gtest/gtest.h>

#include <numbers>

namespace dadrl {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

CollisionSummary Collision(ContactSide side, double degrees, double ego_speed = 5.0) {
  return {.side = side, .ego_speed_mps = ego_speed, .relative_heading_rad = degrees * kDegree};
}

TEST(CollisionKind, FollowsHeadingAndSide) {
  EXPECT_EQ(CollisionKind(Collision(ContactSide::kFront, -44)), "ran_into");
  EXPECT_EQ(CollisionKind(Collision(ContactSide::kRear, 10)), "rear_ended");
  EXPECT_EQ(CollisionKind(Collision(ContactSide::kLeft, 10)), "side_by_side");
  EXPECT_EQ(CollisionKind(Collision(ContactSide::kFront, 46)), "crossing");
  EXPECT_EQ(CollisionKind(Collision(ContactSide::kRear, -90)), "crossing");
  EXPECT_EQ(CollisionKind(Collision(ContactSide::kFront, -136)), "oncoming");
}

TEST(CollisionKind, StandingComesBeforeRearEndedBeforeLaneChange) {
  CollisionSummary collision = Collision(ContactSide::kRear, 0, 0.49);
  collision.lane_changer = LaneChanger::kEgo;
  EXPECT_EQ(CollisionKind(collision), "standing");
  collision.ego_speed_mps = 0.5;
  EXPECT_EQ(CollisionKind(collision), "rear_ended");
  collision.side = ContactSide::kFront;
  EXPECT_EQ(CollisionKind(collision), "lane_change");
}

TEST(CollisionNames, RoundTrip) {
  for (const ContactSide side :
       {ContactSide::kFront, ContactSide::kLeft, ContactSide::kRight, ContactSide::kRear}) {
    EXPECT_EQ(ContactSideFromName(ContactSideName(side)), side);
  }
  for (const LaneChanger changer :
       {LaneChanger::kNobody, LaneChanger::kEgo, LaneChanger::kOther, LaneChanger::kBoth}) {
    EXPECT_EQ(LaneChangerFromName(LaneChangerName(changer)), changer);
  }
  EXPECT_FALSE(ContactSideFromName("nobody"));
  EXPECT_FALSE(LaneChangerFromName("front"));
}

}  // namespace
}  // namespace dadrl
