// A stopped run with experience for `dadrl replay ...` to work on.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "replay/table.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl {

inline const DrivingShape kSpec;

class ToolsTest : public testing::Test {
 protected:
  ToolsTest() : run_(folder_.path() / "run"), shard_(run_ / "replay" / "shard-0") {}

  std::unique_ptr<ReplayTable> OpenTable() {
    TableOptions options{.directory = shard_, .spec = kSpec, .replay = {}, .n_step = 1};
    options.replay.segment_bytes = 1 << 16;
    options.replay.max_disk_bytes = 1 << 28;  // so that segments may be this small
    return std::move(*ReplayTable::Open(options, clock_));
  }
  // Two actors: one terminates each episode, one is truncated in a chunk of its own; the last episode is
  // open.
  void Store(int rounds, FloatCoding floats = FloatCoding::kFloat16) {
    const auto table = OpenTable();
    for (int i = 0; i < rounds; ++i) Round(*table, floats);
    ASSERT_TRUE(table->Insert(MakeSyntheticChunk(kSpec, {.identity = {1, 5, sequence_ + 1},
                                                         .episode = sequence_ + 1,
                                                         .frames = 3,
                                                         .policy_version = 9,
                                                         .floats = floats})));
    ASSERT_TRUE(table->SaveState());
  }
  void Round(ReplayTable& table, FloatCoding floats) {
    ++sequence_;
    ASSERT_TRUE(table.Insert(MakeSyntheticChunk(kSpec, {.identity = {1, 5, sequence_},
                                                        .episode = sequence_,
                                                        .frames = 20,
                                                        .end = kTerminated | kSuccess,
                                                        .policy_version = 2,
                                                        .floats = floats})));
    ASSERT_TRUE(table.Insert(MakeSyntheticChunk(kSpec, {.identity = {2, 6, sequence_},
                                                        .episode = sequence_,
                                                        .frames = 10,
                                                        .end = kTruncated,
                                                        .final_frame = true,
                                                        .policy_version = 3,
                                                        .floats = floats})));
  }
  std::filesystem::path FirstSegment() const {
    std::vector<std::filesystem::path> segments;
    for (const auto& entry : std::filesystem::directory_iterator(shard_)) {
      if (entry.path().extension() == ".log") segments.push_back(entry.path());
    }
    return *std::min_element(segments.begin(), segments.end());
  }
  std::string At(const char* name) const { return (folder_.path() / name).string(); }

  SystemClock clock_;
  MemoryFolder folder_;
  std::filesystem::path run_;
  std::filesystem::path shard_;
  uint64_t sequence_ = 0;
};

}  // namespace dadrl
