// Experience of one run as the beginning of another: what offline training learns from.
#pragma once

#include <filesystem>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/local/run_directory.h"

namespace dadrl {

// Copies what the replay of `from`, a collection or a run, holds into the replay of the new run `to`;
// counters and priorities begin anew. kInvalidArgument, with key and both values, when `from` was made for
// other observations, another task or another number of shards than `config`; also when nothing could be
// learnt from it because nothing is inserted either. kNotFound: no run; kUnavailable: it is being written.
Status CopyExperience(const std::filesystem::path& from, const RunPaths& to, const Config& config);

}  // namespace dadrl
