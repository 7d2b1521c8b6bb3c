// Contact between vehicles as oriented boxes; SUMO's own collision list is not used (it misses side impacts).
#pragma once

#include "actor/sim/geometry.h"
#include "actor/sim/world_state.h"

namespace dadrl {

// Boxes this near count as touching (SMARTS).
constexpr double kContactDistance = 0.05;

// The ego, or anything of its size, at `pose`.
inline OrientedBox EgoBox(const Pose& pose) { return {pose, kVehicleLength, kVehicleWidth}; }

// Metres; 0 when they overlap.
double BoxDistance(const OrientedBox& a, const OrientedBox& b);

// True when BoxDistance(a, b) <= clearance; cheap for boxes that are far apart.
bool BoxesWithin(const OrientedBox& a, const OrientedBox& b, double clearance);

// True when the ego touches any vehicle.
bool EgoTouchesAny(const WorldState& world);

}  // namespace dadrl
