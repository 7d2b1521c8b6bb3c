// Contact between vehicles as oriented boxes; SUMO's own collision list is not used (it misses side impacts).
#pragma once

#include "actor/sim/geometry.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// Boxes this near count as touching (SMARTS).
constexpr double kContactDistance = 0.05;

// Distance between two kVehicleLength x kVehicleWidth boxes, metres; 0 when they overlap.
double BoxDistance(const Pose& a, const Pose& b);

// True when BoxDistance(a, b) <= clearance; cheap for boxes that are far apart.
bool BoxesWithin(const Pose& a, const Pose& b, double clearance);

// True when the ego touches any vehicle.
bool EgoTouchesAny(const WorldState& world);

}  // namespace dadrl
