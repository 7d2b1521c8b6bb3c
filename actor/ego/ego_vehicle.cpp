#include "actor/ego/ego_vehicle.h"

#include <algorithm>
#include <cmath>

#include "actor/sim/ego_motion.h"

namespace dadrl {
namespace {

constexpr int kSubsteps = 5;
constexpr double kSubstep = kStepSeconds / kSubsteps;
const double kSteeringShare = 1.0 - std::exp(-kSubstep / 0.13);  // lag of 0.13 s
const double kDriveShare = 1.0 - std::exp(-kSubstep / 0.35);     // lag of 0.35 s
constexpr double kSpeedGain = 4.0;                               // 1/s
constexpr double kMaxDrive = 8.4;                                // m/s^2
constexpr double kMaxBraking = 7.4;                              // m/s^2
// The reference point is half way between the axles.
constexpr double kRearShare = 0.5;

// From the tangent of the front wheel's angle.
double SlipAngle(double steering_tangent) { return std::atan(kRearShare * steering_tangent); }

}  // namespace

void EgoVehicle::Reset(const Pose& pose, double speed_mps) {
  state_ = EgoState();
  state_.pose = pose;
  state_.speed_mps = state_.velocity_lon = speed_mps;
  drive_ = 0.0;
}

void EgoVehicle::Step(double target_speed_mps, double target_steering_rad) {
  const double steering = std::clamp(target_steering_rad, -kMaxSteering, kMaxSteering);
  const EgoState before = state_;
  for (int i = 0; i < kSubsteps; ++i) Advance(target_speed_mps, steering);
  const double slip = SlipAngle(std::tan(state_.steering_rad));
  state_.velocity_lon = state_.speed_mps * std::cos(slip);
  state_.velocity_lat = state_.speed_mps * std::sin(slip);
  CompleteMotion(before, state_);
}

void EgoVehicle::Advance(double target_speed_mps, double target_steering_rad) {
  state_.steering_rad += kSteeringShare * (target_steering_rad - state_.steering_rad);
  double acceleration =
      std::clamp(kSpeedGain * (target_speed_mps - state_.speed_mps), -kMaxBraking, kMaxDrive);
  // Only the build-up of the drive lags: easing off and braking act at once, so nothing swings about the
  // target.
  drive_ = acceleration > 0.0 ? drive_ + kDriveShare * (acceleration - drive_) : 0.0;
  if (acceleration > 0.0) acceleration = std::min(acceleration, drive_);
  state_.speed_mps = std::max(0.0, state_.speed_mps + kSubstep * acceleration);

  const double tangent = std::tan(state_.steering_rad);
  const double slip = SlipAngle(tangent);
  const double turn = kSubstep * state_.speed_mps * std::cos(slip) * tangent / kWheelbase;
  const double course = state_.pose.heading + 0.5 * turn + slip;
  state_.pose.position = state_.pose.position + kSubstep * state_.speed_mps * Forward(course);
  state_.pose.heading = WrapAngle(state_.pose.heading + turn);
}

}  // namespace dadrl
