// Reads the network that libsumo has loaded.
#pragma once

#include "actor/sim/road_map.h"

namespace dadrl {

// Lanes for pedestrians and the like do not exist in the scenarios' networks. Throws what libsumo throws.
RoadMap ReadSumoNetwork();

}  // namespace dadrl
