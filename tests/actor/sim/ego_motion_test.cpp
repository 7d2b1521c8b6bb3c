#include "actor/sim/ego_motion.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

TEST(EgoMotion, BrakingIsLongitudinal) {
  EgoState before;
  before.speed_mps = before.velocity_lon = 10.0;
  EgoState now = before;
  now.velocity_lon = 9.5;
  CompleteMotion(before, now);
  EXPECT_NEAR(now.acceleration_lon, -5.0, 1e-9);
  EXPECT_NEAR(now.jerk_lon, -50.0, 1e-9);
  EXPECT_NEAR(now.acceleration_lat, 0.0, 1e-9);
}

TEST(EgoMotion, SteadyTurnHasOnlyCentripetalAcceleration) {
  // 5 m/s on a circle of 10 m: 0.5 rad/s, 2.5 m/s^2 to the left.
  EgoState state;
  state.velocity_lon = 5.0;
  for (int step = 0; step < 5; ++step) {
    EgoState now;
    now.velocity_lon = 5.0;
    now.pose.heading = state.pose.heading + 0.05;
    CompleteMotion(state, now);
    state = now;
  }
  EXPECT_NEAR(state.yaw_rate, 0.5, 1e-9);
  EXPECT_NEAR(state.acceleration_lat, 2.5, 0.01);
  EXPECT_NEAR(state.acceleration_lon, 0.0, 0.07);
  EXPECT_NEAR(state.jerk_lat, 0.0, 1e-6);
  EXPECT_NEAR(state.angular_acceleration, 0.0, 1e-9);
}

TEST(EgoMotion, YawRateCrossesTheHalfTurn) {
  EgoState before;
  before.pose.heading = 3.14;
  EgoState now;
  now.pose.heading = -3.14;
  CompleteMotion(before, now);
  EXPECT_NEAR(now.yaw_rate, 0.0318, 1e-3);
}

}  // namespace
}  // namespace dadrl
