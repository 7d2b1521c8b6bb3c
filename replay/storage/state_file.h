// What the replay must remember beyond the segments it still holds: one small file beside them, written
// atomically at intervals, whenever a segment is closed, with a snapshot, and when the service drains.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "common/util/result.h"
#include "replay/item_states.h"
#include "replay/rate_limiter.h"
#include "replay/sequence_table.h"
#include "replay/storage/segment.h"

namespace dadrl {

struct ReplayState {
  // Other bounds than the configuration's, set while running.
  struct LimiterChange {
    RateLimiter::Options configured;
    RateLimiter::Options current;
  };
  uint64_t schema = 0;
  LogPosition up_to;  // everything here counts the records before it, and none behind
  RateLimiter::State limiter;
  std::optional<LimiterChange> limiter_change;
  SequenceTable sequences;
  ItemStates items;
};

// Blocks on the disk. kExhausted: disk full; the earlier file is untouched.
Status WriteReplayState(const std::filesystem::path& file, const ReplayState& state);
// kNotFound: there is none. kCorrupt: it cannot be used.
Result<ReplayState> ReadReplayState(const std::filesystem::path& file);

}  // namespace dadrl
