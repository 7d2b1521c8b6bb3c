#include "actor/sim/ego_motion.h"

#include <cmath>

namespace dadrl {
namespace {

Point VelocityInWorld(const EgoState& ego) {
  const Point forward = Forward(ego.pose.heading);
  const Point left{-forward.y, forward.x};
  return ego.velocity_lon * forward + ego.velocity_lat * left;
}

}  // namespace

void CompleteMotion(const EgoState& before, EgoState& now) {
  constexpr double kPerSecond = 1.0 / kStepSeconds;
  const Point acceleration = kPerSecond * (VelocityInWorld(now) - VelocityInWorld(before));
  const Point forward = Forward(now.pose.heading);
  now.acceleration_lon = Dot(acceleration, forward);
  now.acceleration_lat = Cross(forward, acceleration);
  now.jerk_lon = kPerSecond * (now.acceleration_lon - before.acceleration_lon);
  now.jerk_lat = kPerSecond * (now.acceleration_lat - before.acceleration_lat);
  now.yaw_rate = kPerSecond * WrapAngle(now.pose.heading - before.pose.heading);
  now.angular_acceleration = kPerSecond * (now.yaw_rate - before.yaw_rate);
}

bool IsFinite(const EgoState& ego) {
  return std::isfinite(ego.pose.position.x) && std::isfinite(ego.pose.position.y) &&
         std::isfinite(ego.pose.heading) && std::isfinite(ego.speed_mps);
}

}  // namespace dadrl
