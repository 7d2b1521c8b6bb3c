// The process `dadrl-learner`: joins the cluster, resumes or starts, trains, leaves a checkpoint.
#pragma once

#include <filesystem>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// Trains until learner.max_updates, learner.max_cpu_seconds, minutes, SIGINT or SIGTERM (install the handler
// first). Without `resume` the run directory must hold no checkpoint; with it the newest whole checkpoint is
// taken, and a run that has none yet starts from the beginning.
Status RunLearner(const Config& config, const std::filesystem::path& run_directory, bool resume);

}  // namespace dadrl
