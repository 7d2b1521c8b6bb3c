// Where a run keeps its snapshots: <run directory>/snapshots/shard-K/NAME.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

std::filesystem::path SnapshotFolder(const std::filesystem::path& run_directory, uint32_t shard);

// kInvalidArgument when `name` is not a plain name of 1 to 64 letters, digits, '-', '_' and '.'.
Status CheckSnapshotName(const std::string& name);
// "20260131T235959Z": sorts by time.
std::string AutomaticSnapshotName(int64_t wall_time_ns);
// Removes all automatic snapshots of `folder` but the newest `kept`.
void RemoveOldSnapshots(const std::filesystem::path& folder, int kept);

}  // namespace dadrl
