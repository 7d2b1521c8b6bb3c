// A table in a folder that is opened again and again.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <memory>
#include <vector>

#include "replay/table.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {

class TableRecovery : public testing::Test {
 protected:
  using Insertion = ReplayTable::Insertion;

  static TableOptions Options(const std::filesystem::path& directory) {
    TableOptions options{.directory = directory, .spec = kTestSpec, .replay = {}, .n_step = 2};
    options.replay.min_size = 1;
    options.replay.samples_per_insert = 0.0;
    options.replay.max_disk_bytes = 1 << 20;
    options.replay.segment_bytes = 1 << 16;
    options.replay.max_times_sampled = 1;
    return options;
  }
  std::unique_ptr<ReplayTable> Open(const TableOptions& options) {
    return ReplayTable::Open(options, clock_).value();
  }
  std::unique_ptr<ReplayTable> Open() { return Open(Options(folder_.path())); }

  // Episodes of two chunks of five frames, the second of which ends it.
  static TestChunk ChunkOf(uint64_t sequence) {
    const bool second = sequence % 2 == 0;
    return {.identity = {1, 7, sequence},
            .episode = (sequence + 1) / 2,
            .first_frame = second ? 5u : 0u,
            .frames = 5,
            .end = static_cast<uint8_t>(second ? kTerminated : 0)};
  }
  // The chunks `first` to `last`.
  static void Store(ReplayTable& table, uint64_t first, uint64_t last) {
    for (uint64_t sequence = first; sequence <= last; ++sequence) {
      ASSERT_EQ(table.Insert(Build(ChunkOf(sequence))), Insertion::kStored) << sequence;
    }
  }
  // Every slice in the table as first reward -> its rewards; samples everything.
  static std::map<float, std::vector<float>> SampleAll(ReplayTable& table) {
    std::map<float, std::vector<float>> slices;
    const size_t items = table.stats().items;
    if (items == 0) return slices;
    const auto batch = table.Sample({static_cast<int>(items), 2}, 0).value();
    for (const SampledTrajectory& item : batch.trajectories) {
      EXPECT_EQ(Decode(item.payloads.front()), item.steps[0].reward);
      const bool inserted = slices.try_emplace(item.steps[0].reward, RewardsOf(item)).second;
      EXPECT_TRUE(inserted) << "frame " << item.steps[0].reward << " is there twice";
    }
    return slices;
  }

  SystemClock clock_;
  MemoryFolder folder_;
};

}  // namespace dadrl
