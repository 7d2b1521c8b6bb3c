// What the replay must remember beyond the segments it still holds: one small file beside them, written
// atomically at intervals, whenever a segment is closed, with a snapshot, and when the service drains.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

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

// A state is never longer than this, beside segments of so many bytes: each chunk and each frame takes more
// there than here. What is written can therefore be read.
uint64_t MaxStateBytes(uint64_t segment_bytes);

std::vector<std::byte> EncodeReplayState(const ReplayState& state);
// kCorrupt: `bytes` are no state, or hold numbers that no replay has had. `name` is for the error text.
Result<ReplayState> DecodeReplayState(std::span<const std::byte> bytes, const std::string& name);

// Blocks on the disk. kExhausted: disk full; the earlier file is untouched.
Status WriteReplayState(const std::filesystem::path& file, const ReplayState& state);
// kNotFound: there is none. kCorrupt: it cannot be used, or is longer than `max_bytes` (nothing is allocated
// then).
Result<ReplayState> ReadReplayState(const std::filesystem::path& file, uint64_t max_bytes);

}  // namespace dadrl
