// `dadrl-actor collect`: one actor of a cluster, from its configuration to its exit code.
#pragma once

#include <filesystem>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

struct CollectOptions {
  Config config;
  std::filesystem::path run_directory;  // logs/episodes-actor-N.csv goes here
  int index = 0;                        // its number in the run, and in the names of its files
  // The run gives out a number; then `index` only stands in the names of its files.
  bool any_number = false;
};

// Drives and sends experience until shutdown_requested, then waits a few seconds for the last
// acknowledgements. Waits, without end, for a replay that is not there. The exit code: 0, or kExitTurnedAway
// when another actor has the number, with the reason in the log. kInvalidArgument: the configuration, an
// unknown scenario, a replay of another version or a learner with another network; kInternal: the simulator
// cannot be used.
Result<int> RunCollect(const CollectOptions& options);

}  // namespace dadrl
