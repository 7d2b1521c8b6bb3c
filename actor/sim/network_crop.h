// The part of a large network that a scenario can have to do with.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "actor/sim/memory_file.h"
#include "actor/sim/scenario.h"
#include "common/util/result.h"

namespace dadrl {

// Networks whose file is smaller are taken whole.
constexpr uintmax_t kCropBytes = uintmax_t{1} << 20;
// What is farther from every edge of the route and of the flows is left out.
constexpr double kCropMetres = 500.0;

// The network of `scenario` without what is far from it, as a file that SUMO reads: SUMO would read the whole
// at the start of every episode. Lanes, junctions, right of way and traffic lights near it are as they were;
// at the rim junctions are dead ends. Nothing for a network that is taken whole: a small one, one that is not
// plain XML, one that lacks an edge that the scenario names (who reads it says which), and where the scenario
// has files of its own, whose vehicles may be anywhere. kExhausted: no memory for the file.
Result<std::optional<MemoryFile>> CropNetwork(const Scenario& scenario, const ProfileSettings& profile);

// The same of a network as text, with the edges to keep near: `network` is cut in place. False, with
// `network` as it was, when it cannot be cut.
bool CropNetworkXml(std::string& network, const std::vector<std::string>& edges, double metres);

}  // namespace dadrl
