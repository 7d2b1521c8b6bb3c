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

// The action that asks for `command`, as far as actions can: no speed above `max_speed_mps`.
inline Action ActionOf(const DriveCommand& command, double max_speed_mps) {
  const double share = std::clamp(command.target_speed_mps / max_speed_mps, 0.0, 1.0);
  return {static_cast<float>(2.0 * share - 1.0), static_cast<float>(std::clamp(command.lane, -1, 1))};
}

}  // namespace dadrl
