// What follows from two poses of the ego in a row.
#pragma once

#include "actor/sim/world_state.h"

namespace dadrl {

// Fills in `now`'s yaw rate, accelerations, jerks and angular acceleration from `before`, one simulation step
// earlier. `now` holds pose, speed and the two velocities already. Accelerations are the ego's true ones
// (a steady turn has a lateral acceleration), seen in its current frame; jerks are their change per second.
void CompleteMotion(const EgoState& before, EgoState& now);

// Whether pose and speed are numbers.
bool IsFinite(const EgoState& ego);

}  // namespace dadrl
