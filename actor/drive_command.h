// What a driver asks of the ego, in the controller's terms.
#pragma once

#include <algorithm>

#include "common/step/driving_shape.h"

namespace dadrl {

struct DriveCommand {
  double target_speed_mps = 0.0;  // >= 0; may exceed task.max_speed_mps
  int lane = 0;                   // -1 right, 0 keep, +1 left
};

// A policy's action (paper, section IV): the target speed is max_speed (a0 + 1) / 2; a1 below -1/3 is right,
// above 1/3 left. Values beyond +-1 are clamped; `action` is finite.
inline DriveCommand CommandOf(const Action& action, double max_speed_mps) {
  constexpr float kLaneThreshold = 1.0f / 3.0f;
  DriveCommand command;
  command.target_speed_mps = max_speed_mps * (std::clamp(action[0], -1.0f, 1.0f) + 1.0) / 2.0;
  command.lane = action[1] < -kLaneThreshold ? -1 : action[1] > kLaneThreshold ? 1 : 0;
  return command;
}

}  // namespace dadrl
