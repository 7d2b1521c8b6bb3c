// Puts a snapshot in place of a stopped run's experience.
#pragma once

#include <filesystem>
#include <string>

#include "common/util/result.h"

namespace dadrl {

// Where a restore leaves what was there before.
std::filesystem::path ReplacedReplay(const std::filesystem::path& run);

// All shards or none; a restore that was killed can be repeated. Takes regular files of the snapshot alone,
// and only those that a replay reads: links are refused, nothing is written outside `run`. kInvalidArgument:
// no name of a snapshot, or what an earlier restore replaced is still there; kNotFound: a shard has no such
// snapshot; kUnavailable: the run is at work. Blocks on the disk.
Status RestoreSnapshot(const std::filesystem::path& run, const std::string& name);

}  // namespace dadrl
