// Which clusters ask for a key (common/io/run_key.h), and that with which a process of a run takes part.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl::dds {

// Whether only who has the run's key takes part; `cluster.host` in dotted form.
bool AsksForKey(const ClusterConfig& cluster);

// The key in `run_directory`; "" when `cluster` asks for none. Where it does and the file is missing, a link
// or damaged, the error says how to get one: nobody takes part without. Blocks on the resolver.
Result<std::string> LoadClusterKey(const std::filesystem::path& run_directory, const ClusterConfig& cluster);

}  // namespace dadrl::dds
