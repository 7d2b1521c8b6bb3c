// Reads the network that libsumo has loaded.
#pragma once

#include <filesystem>
#include <string>

#include "actor/sim/road_map.h"
#include "common/util/result.h"

namespace dadrl {

// Whether SUMO lets vehicles of `vehicle_class` ("passenger", "truck", "bicycle", ...) use the lane. Throws
// what libsumo throws.
bool LaneAllows(const std::string& lane, const std::string& vehicle_class);

// The lanes that cars may use. Pavements, crossings, cycle lanes, rails and everything else that is closed to
// cars is left out, and so are lanes without length (where a speed limit changes on a straight road): what
// leads into one leads into what follows it. Throws what libsumo throws.
RoadMap ReadSumoNetwork();

// Loads it into libsumo, whatever that held before. kInvalidArgument: SUMO cannot read the file, with its
// words and the remedy. Nothing is thrown.
Status LoadSumoNetwork(const std::filesystem::path& network);

// The same as a map. What SUMO says is part of the error, not on standard error.
Result<RoadMap> LoadRoadMap(const std::filesystem::path& network);

// Of an edge of the loaded network; empty where it has none. Throws what libsumo throws.
std::string StreetName(const std::string& edge);

}  // namespace dadrl
