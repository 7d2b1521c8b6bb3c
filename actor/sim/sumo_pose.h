// Between SUMO's vehicle positions (front bumper, degrees clockwise from north) and the task's poses.
#pragma once

#include <string>

#include "actor/sim/geometry.h"

namespace dadrl {

// Throws what libsumo throws.
Pose PoseFromSumo(const std::string& vehicle);

// Puts a vehicle's box at `pose`, on the road or off it. Throws what libsumo throws.
void MoveInSumo(const std::string& vehicle, const Pose& pose, double speed_mps);

}  // namespace dadrl
