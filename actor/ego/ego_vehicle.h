// The ego's body: a kinematic bicycle with lagging steering and drive.
#pragma once

#include "actor/sim/world_state.h"

namespace dadrl {

constexpr double kWheelbase = 3.0;
constexpr double kMaxSteering = 0.722;  // rad, front wheel

// Response measured on the paper's simulator (paper code: 3.68 m box, 2.4 t, four-wheel drive): brakes at
// 7.4 m/s^2 without delay, drives at up to 8.4 m/s^2 with a lag, steers with a lag of 0.13 s. Not thread
// safe.
class EgoVehicle {
 public:
  // Standing straight on its wheels at `pose` (of the box's centre), rolling with `speed_mps`.
  void Reset(const Pose& pose, double speed_mps);

  // One simulation step of 0.1 s towards the target speed (>= 0) and front-wheel angle. Both finite; the
  // angle is clamped to +-kMaxSteering.
  void Step(double target_speed_mps, double target_steering_rad);

  const EgoState& state() const { return state_; }

 private:
  void Advance(double target_speed_mps, double target_steering_rad);

  EgoState state_;
  double drive_ = 0.0;  // lagging acceleration of the drive, m/s^2
};

}  // namespace dadrl
