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
// The same for the next snapshot in `folder`, which shall sort behind all automatic ones there also when the
// clock was set back: otherwise the new one would be taken for the oldest, and leave.
std::string NextSnapshotName(const std::filesystem::path& folder, int64_t wall_time_ns);
// What a shard's snapshots cost: files that the shard itself still holds are theirs together, and cost
// nothing.
struct SnapshotUse {
  uint64_t snapshots = 0;
  uint64_t bytes = 0;  // of files that only snapshots hold
};
// `folder` as SnapshotFolder names it, `shard` the folder of the replay itself. What cannot be read is not
// counted.
SnapshotUse UseOfSnapshots(const std::filesystem::path& folder, const std::filesystem::path& shard);

// Where `snapshot` is while it is written or removed: half of one is never under its name.
std::filesystem::path PartialSnapshot(const std::filesystem::path& snapshot);
// Removes all automatic snapshots of `folder` but the newest `kept`.
Status RemoveOldSnapshots(const std::filesystem::path& folder, int kept);
// Removes what a process left that was killed while it wrote or removed one.
Status RemovePartialSnapshots(const std::filesystem::path& folder);

}  // namespace dadrl
