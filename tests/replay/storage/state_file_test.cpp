#include "replay/storage/state_file.h"

#include <gtest/gtest.h>

#include <fstream>

#include "common/io/read_file.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

TEST(StateFile, ComesBackAsItWasWritten) {
  MemoryFolder folder;
  ReplayState state{.schema = 5, .up_to = {7, 70}, .limiter = {10, 20, 1.5, 2.5}};
  state.sequences.Accept({3, 4, 5});
  state.limiter_change = {{.min_size = 1}, {.min_size = 2, .max_samples_per_insert = 3.0}};
  state.items.max_priority = 4.0;
  state.items.newest_version = 9;
  state.items.chunks = {{7, 1234, 2}, {7, 5678, 1}};
  state.items.priorities = {0.5f, ItemStates::kRemoved, ItemStates::kNoItem};
  state.items.times_sampled = {3, 0, 0};
  const auto file = folder.path() / "state";
  ASSERT_TRUE(WriteReplayState(file, state));
  const auto read = ReadReplayState(file);
  ASSERT_TRUE(read) << read.error().message;
  EXPECT_EQ(read->schema, 5u);
  EXPECT_EQ(read->up_to, (LogPosition{7, 70}));
  EXPECT_EQ(read->limiter.inserted, 10);
  EXPECT_EQ(read->limiter.sampled, 20);
  EXPECT_EQ(read->limiter.sample_credit, 1.5);
  EXPECT_EQ(read->limiter.insert_debt, 2.5);
  EXPECT_EQ(read->sequences.Stored(3, 4), 5u);
  ASSERT_TRUE(read->limiter_change);
  EXPECT_EQ(read->limiter_change->configured, state.limiter_change->configured);
  EXPECT_EQ(read->limiter_change->current, state.limiter_change->current);
  EXPECT_EQ(read->items.max_priority, 4.0);
  EXPECT_EQ(read->items.newest_version, 9u);
  ASSERT_EQ(read->items.chunks.size(), 2u);
  EXPECT_EQ(read->items.chunks[1].checksum, 5678u);
  EXPECT_EQ(read->items.priorities, state.items.priorities);
  EXPECT_EQ(read->items.times_sampled, state.items.times_sampled);
}

TEST(StateFile, DamageAndAbsenceAreToldApart) {
  MemoryFolder folder;
  const auto file = folder.path() / "state";
  EXPECT_EQ(ReadReplayState(file).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(WriteReplayState(file, {}));
  const auto good = ReadTextFile(file, 1 << 20).value();
  for (size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 1);
    std::ofstream(file, std::ios::trunc) << bad;
    EXPECT_EQ(ReadReplayState(file).error().code, ErrorCode::kCorrupt);
    std::ofstream(file, std::ios::trunc) << good.substr(0, i);
    EXPECT_EQ(ReadReplayState(file).error().code, ErrorCode::kCorrupt);
  }
}

}  // namespace
}  // namespace dadrl
