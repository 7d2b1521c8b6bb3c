#include "actor/ego/ego_vehicle.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dadrl {
namespace {

// Seconds until 95 % of the way from one speed to the other is done.
double ResponseTime(double from, double to) {
  EgoVehicle vehicle;
  vehicle.Reset({}, from);
  double before = from;
  for (int step = 1; step < 100; ++step) {
    vehicle.Step(to, 0.0);
    const double now = vehicle.state().speed_mps;
    const double threshold = from + 0.95 * (to - from);
    if ((now - threshold) * (to - from) >= 0.0) {
      return 0.1 * (step - 1 + (threshold - before) / (now - before));
    }
    before = now;
  }
  return INFINITY;
}

TEST(EgoVehicle, RespondsLikeThePapersVehicle) {
  EXPECT_NEAR(ResponseTime(0.0, 10.0), 1.6, 0.16);
  EXPECT_NEAR(ResponseTime(10.0, 0.0), 1.35, 0.135);
}

TEST(EgoVehicle, AccelerationStaysWithinItsLimits) {
  EgoVehicle vehicle;
  vehicle.Reset({}, 0.0);
  double most = 0.0, least = 0.0;
  for (int step = 0; step < 60; ++step) {
    vehicle.Step(step < 30 ? 30.0 : 0.0, 0.0);
    most = std::max(most, vehicle.state().acceleration_lon);
    least = std::min(least, vehicle.state().acceleration_lon);
  }
  EXPECT_NEAR(most, 8.4, 0.2);
  EXPECT_NEAR(least, -7.4, 1e-6);
}

TEST(EgoVehicle, StopsWithinTheApproachOfTheJunction) {
  EgoVehicle vehicle;
  vehicle.Reset({}, 10.0);
  for (int step = 0; step < 50; ++step) vehicle.Step(0.0, 0.0);
  EXPECT_LT(vehicle.state().speed_mps, 0.01);
  EXPECT_NEAR(vehicle.state().pose.position.x, 7.2, 0.5);
}

TEST(EgoVehicle, NeitherOvershootsNorChatters) {
  for (const double target : {0.0, 2.0, 5.56, 10.0}) {
    for (const double start : {0.0, 5.0, 13.89}) {
      EgoVehicle vehicle;
      vehicle.Reset({}, start);
      for (int step = 0; step < 300; ++step) {
        vehicle.Step(target, 0.0);
        const EgoState& state = vehicle.state();
        EXPECT_GE(state.speed_mps, std::min(start, target) - 1e-9);
        EXPECT_LE(state.speed_mps, std::max(start, target) + 1e-9);
        if (step >= 35) {
          EXPECT_LT(std::hypot(state.jerk_lon, state.jerk_lat), 1.0) << target << " " << step;
        }
      }
      EXPECT_NEAR(vehicle.state().speed_mps, target, 1e-3);
    }
  }
}

TEST(EgoVehicle, TurnsOnTheBicyclesCircle) {
  // beta = atan(tan(d) / 2); radius of the centre = wheelbase / (cos(beta) tan(d)).
  const double steering = 0.3;
  const double slip = std::atan(0.5 * std::tan(steering));
  const double radius = kWheelbase / (std::cos(slip) * std::tan(steering));
  EgoVehicle vehicle;
  vehicle.Reset({}, 5.0);
  for (int step = 0; step < 40; ++step) vehicle.Step(5.0, steering);
  const EgoState& state = vehicle.state();
  EXPECT_NEAR(state.yaw_rate, 5.0 / radius, 1e-3);
  EXPECT_NEAR(std::hypot(state.acceleration_lon, state.acceleration_lat), 25.0 / radius, 0.02);
  EXPECT_NEAR(state.velocity_lat, 5.0 * std::sin(slip), 1e-3);
  EXPECT_NEAR(state.angular_acceleration, 0.0, 1e-2);
}

TEST(EgoVehicle, SteeringLagsAndIsLimited) {
  EgoVehicle vehicle;
  vehicle.Reset({}, 0.0);
  vehicle.Step(0.0, 2.0);
  EXPECT_NEAR(vehicle.state().steering_rad, kMaxSteering * (1 - std::exp(-0.1 / 0.13)), 1e-9);
  for (int step = 0; step < 50; ++step) vehicle.Step(0.0, 2.0);
  EXPECT_NEAR(vehicle.state().steering_rad, kMaxSteering, 1e-6);
}

}  // namespace
}  // namespace dadrl
