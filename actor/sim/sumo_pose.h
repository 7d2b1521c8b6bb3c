// Between SUMO's vehicle positions (front bumper, degrees clockwise from north) and the task's poses.
#pragma once

#include <string>

#include "actor/sim/geometry.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// Of the centre of a box of `length_m`. Throws what libsumo throws.
Pose PoseFromSumo(const std::string& vehicle, double length_m = kVehicleLength);

// Of the road under the vehicle, metres. Throws what libsumo throws.
double ElevationFromSumo(const std::string& vehicle);

// Puts the ego's box at `pose`, on the road or off it. Where roads lie above each other, `edge` and
// `lane_index` say which is meant; an empty edge is whichever is nearest. Throws what libsumo throws.
void MoveInSumo(const std::string& vehicle, const Pose& pose, double speed_mps, const std::string& edge = "",
                int lane_index = 0);

}  // namespace dadrl
