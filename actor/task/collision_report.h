// What a collision was like, for those who count failures by kind.
#pragma once

#include <optional>

#include "actor/sensing/localization.h"
#include "actor/sim/road_map.h"
#include "actor/sim/world_state.h"
#include "proto/evaluation/collision_summary.h"

namespace dadrl {

// A vehicle counts as leaving its lane when it drives along the lane nearest to it (within 45 degrees) with
// its centre farther than this from the lane's centre line: lane keeping stays well within it, half way
// through a change is 1.6 m.
constexpr double kLaneKeepingOffset = 0.5;

// The collision of an ego that touches a vehicle (of several, the one whose centre is nearest); nothing when
// it touches none.
std::optional<CollisionSummary> DescribeCollision(const WorldState& world, const EgoLocation& location,
                                                  const RoadMap& map);

}  // namespace dadrl
