// A replay as it was at one moment, as a folder beside the running one.
//
// A snapshot has the layout of a shard's folder: segments and state. A replay opens it like its own folder,
// and the tools read it like any other. Sealed segments never change, so their files are linked, not copied:
// a snapshot costs no space until the running replay drops what it shares with it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>

#include "common/util/result.h"
#include "replay/storage/segment_log.h"
#include "replay/storage/state_file.h"

namespace dadrl {

struct SnapshotReport {
  uint64_t segments = 0;
  uint64_t bytes = 0;
  uint64_t copied_bytes = 0;  // of them: of the open segment, and where links are not possible
};

// Writes `directory`, which must not exist: complete and on the device, or not at all. `state` and `extents`
// are of the same moment. Blocks on the disk; needs no lock: what the log drops meanwhile is copied from
// memory.
Result<SnapshotReport> WriteSnapshot(const ReplayState& state, const StepSpec& spec,
                                     std::span<const SegmentLog::Extent> extents,
                                     const std::filesystem::path& directory);

}  // namespace dadrl
