// A shard's table between its two neighbours, over memory, on a clock of the test's: whoever is tested takes
// turns with them.
#pragma once

#include <gtest/gtest.h>

#include <memory>

#include "common/port/memory_transport.h"
#include "replay/table.h"
#include "tests/replay/service/peers.h"

namespace dadrl {

class MemoryShard : public testing::Test {
 protected:
  MemoryShard() {
    clock_.Advance(std::chrono::hours(1));
    config_.algorithm.n_step = 1;
    config_.replay.min_size = 4;
    config_.replay.samples_per_insert = 0.0;
  }
  // After the configuration is final.
  void OpenTable(Segment::Force force = SyncFile) {
    table_ = ReplayTable::Open({.directory = folder_.path(),
                                .spec = kTestSpec,
                                .replay = config_.replay,
                                .force = std::move(force)},
                               clock_)
                 .value();
  }

  MemoryFolder folder_;
  Config config_;
  ManualClock clock_;
  const MemoryTransport transport_{clock_};
  std::unique_ptr<ReplayTable> table_;
};

}  // namespace dadrl
