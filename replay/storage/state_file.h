// What the replay must remember beyond the segments it still holds: one small file beside them, written
// atomically whenever a segment is closed and when the service drains.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/util/result.h"
#include "replay/rate_limiter.h"
#include "replay/sequence_table.h"

namespace dadrl {

struct ReplayState {
  uint64_t schema = 0;
  uint64_t up_to_segment = 0;  // counts include this segment and those before it, none after
  RateLimiter::State limiter;
  SequenceTable sequences;
};

// Blocks on the disk. kExhausted: disk full; the earlier file is untouched.
Status WriteReplayState(const std::filesystem::path& file, const ReplayState& state);
// kNotFound: there is none. kCorrupt: it cannot be used.
Result<ReplayState> ReadReplayState(const std::filesystem::path& file);

}  // namespace dadrl
