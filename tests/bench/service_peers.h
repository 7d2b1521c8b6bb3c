// What stands around the replay in the service benchmark, each a process of its own: a feeder of chunks, a
// learner that takes batches, and the bare counterpart of the replay.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "common/config/config.h"

namespace dadrl::bench {

// A forked process that runs `work` and hands back the numbers it returns. Create it before this process uses
// DDS: Cyclone does not survive a fork.
class Peer {
 public:
  explicit Peer(const std::function<std::vector<double>()>& work);
  // Kills it when it still runs.
  ~Peer();
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;
  // Waits for it to end; empty when it failed.
  std::vector<double> Wait();

 private:
  int pid_;
  int results_;
};

// Sends `chunks` chunks with the replay's own protocol: no more than granted, again when nothing is heard.
// Returns {seconds until all were stored, median, 99th percentile and largest of the seconds from a chunk to
// its acknowledgement}; without `granting` (a bare peer) everything is granted, and the peer acknowledges
// once.
std::vector<double> Feed(const Config& config, uint64_t chunks, bool granting);

// Feeds until killed.
void FeedForEver(const Config& config);

struct Fetching {
  int batches = 0;
  int outstanding = 1;  // requests
  int replies_of = 1;   // that one request brings
  uint32_t batch_size = 256;
};
// Takes batches; returns {seconds for all, mean bytes, median, 99th percentile and largest of the seconds
// from request to reply}.
std::vector<double> Fetch(const Config& config, const Fetching& fetching);

// The bare counterpart: drops the chunks it takes, says so after `chunks` of them, and answers each request
// with `replies_of` replies of `reply_bytes`. Until killed.
void Mirror(const Config& config, uint64_t chunks, int replies_of, size_t reply_bytes);

}  // namespace dadrl::bench
