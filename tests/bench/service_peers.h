// What stands around the replay in the service benchmark, each for a PeerProcess: a feeder of chunks, a
// learner that takes batches, and the bare counterpart of the replay. What cannot start ends its process.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/config/config.h"
#include "tests/bench/peer_process.h"

namespace dadrl::bench {

// Sends `chunks` chunks with the replay's own protocol: no more than granted, again when nothing is heard.
// The seconds until all were stored; each chunk waits for its acknowledgement. Without `granting` (a bare
// peer) everything is granted, and the peer acknowledges once.
Numbers Feed(const Config& config, uint64_t chunks, bool granting);

// Feeds until killed.
[[noreturn]] void FeedForEver(const Config& config, bool granting);

struct Fetching {
  int batches = 0;
  int outstanding = 1;  // requests
  int replies_of = 1;   // that one request brings
  uint32_t batch_size = 256;
};
// Takes batches; each request waits for its replies.
Numbers Fetch(const Config& config, const Fetching& fetching);

// The bare counterpart: drops the chunks it takes, says so after `chunks` of them, and answers each request
// with `replies_of` replies of `reply_bytes`. Until killed.
[[noreturn]] void Mirror(const Config& config, uint64_t chunks, int replies_of, size_t reply_bytes);

}  // namespace dadrl::bench
