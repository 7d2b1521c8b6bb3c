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
  int index = 0;                        // unique among the actors of the run
};

// Drives and sends experience until shutdown_requested, then waits a few seconds for the last
// acknowledgements. Waits, without end, for a replay that is not there. kInvalidArgument: the configuration,
// an unknown scenario, or a learner with another network; kInternal: the simulator cannot be used.
Status RunCollect(const CollectOptions& options);

}  // namespace dadrl
