// The ways ahead of the ego and of the vehicles around it, as points: the column `polylines`.
#pragma once

#include <span>

#include "actor/sim/road_map.h"
#include "actor/sim/route.h"
#include "actor/sim/world_state.h"
#include "common/step/driving_shape.h"

namespace dadrl {

// Borrows map and route. Any thread; allocates nothing.
class Polylines {
 public:
  Polylines(const RoadMap& map, const Route& route) : map_(map), route_(route) {}

  // Overwrites the way of the ego and those of a vehicle, [2, 10, 5] each, in the ego's frame, by points one
  // metre apart, the first a metre ahead. The ego's: along its route from `route_s` on, and along the lane it
  // is on. A vehicle's: along its lane, straight on where it forks; and the next straightest branch of the
  // first fork within reach, or where there is none the lane beside it, left before right. Points beyond the
  // end of a road, and ways that are not there, are absent.
  void WriteEgo(const EgoState& ego, double route_s, std::span<float> out) const;
  void WriteVehicle(const EgoState& ego, const SocialVehicle& vehicle, std::span<float> out) const;

 private:
  const RoadMap& map_;
  const Route& route_;
};

// The ways of a vehicle that is not there.
void WriteNoWays(std::span<float> out);

}  // namespace dadrl
