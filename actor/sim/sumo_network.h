// Reads the network that libsumo has loaded.
#pragma once

#include <string>

#include "actor/sim/road_map.h"

namespace dadrl {

// Whether SUMO lets vehicles of `vehicle_class` ("passenger", "truck", "bicycle", ...) use the lane. Throws
// what libsumo throws.
bool LaneAllows(const std::string& lane, const std::string& vehicle_class);

// The lanes that cars may use. Pavements, crossings, cycle lanes, rails and everything else that is closed to
// cars is left out, and so are lanes without length (where a speed limit changes on a straight road): what
// leads into one leads into what follows it. Throws what libsumo throws.
RoadMap ReadSumoNetwork();

}  // namespace dadrl
