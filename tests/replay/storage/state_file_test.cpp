#include "replay/storage/state_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/read_file.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

TEST(StateFile, ComesBackAsItWasWritten) {
  MemoryFolder folder;
  ReplayState state{.schema = 5, .up_to = {7, 70}, .limiter = {10, 20, 1.5, 2.5}, .limiter_change = {}};
  state.sequences.Accept({3, 4, 5});
  state.limiter_change = {{.min_size = 1}, {.min_size = 2, .max_samples_per_insert = 3.0}};
  state.items.max_priority = 4.0;
  state.items.newest_version = 9;
  state.items.chunks = {{7, 1234, 2}, {7, 5678, 1}};
  state.items.priorities = {0.5f, ItemStates::kRemoved, ItemStates::kNoItem};
  state.items.times_sampled = {3, 0, 0};
  const auto file = folder.path() / "state";
  ASSERT_TRUE(WriteReplayState(file, state));
  const auto read = ReadReplayState(file, 1 << 20);
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

// As another program computed it from the format: old files and new ones stay the same.
TEST(StateFile, HasTheBytesOfItsFormat) {
  ReplayState state{.schema = 5, .up_to = {7, 70}, .limiter = {10, 20, 1.5, 2.5}, .limiter_change = {}};
  state.sequences.Accept({3, 4, 5});
  state.items.max_priority = 4.0;
  state.items.newest_version = 9;
  const std::vector<std::byte> bytes = EncodeReplayState(state);
  ASSERT_EQ(bytes.size(), 128u);
  EXPECT_EQ(ByteReader(std::span(bytes).last(8)).Get<uint64_t>(), 0x89264fb3092d616au);
  EXPECT_TRUE(CheckedContent(bytes));
}

TEST(StateFile, DamageAndAbsenceAreToldApart) {
  MemoryFolder folder;
  const auto file = folder.path() / "state";
  EXPECT_EQ(ReadReplayState(file, 1 << 20).error().code, ErrorCode::kNotFound);
  ASSERT_TRUE(WriteReplayState(file, {}));
  const auto good = ReadTextFile(file, 1 << 20).value();
  for (size_t i = 0; i < good.size(); ++i) {
    std::string bad = good;
    bad[i] = static_cast<char>(bad[i] ^ 1);
    std::ofstream(file, std::ios::trunc) << bad;
    EXPECT_EQ(ReadReplayState(file, 1 << 20).error().code, ErrorCode::kCorrupt);
    std::ofstream(file, std::ios::trunc) << good.substr(0, i);
    EXPECT_EQ(ReadReplayState(file, 1 << 20).error().code, ErrorCode::kCorrupt);
  }
}

TEST(StateFile, NumbersThatNoReplayHasHadAreRefused) {
  const auto refuses = [](const std::function<void(ReplayState&)>& spoil) {
    ReplayState state{.schema = 5, .up_to = {7, 70}, .limiter = {10, 20, 1.5, 2.5}};
    state.items.chunks = {{7, 1234, 2}};
    state.items.priorities = {0.5f, 1.0f};
    state.items.times_sampled = {3, 0};
    EXPECT_TRUE(DecodeReplayState(EncodeReplayState(state), "state"));
    spoil(state);
    return !DecodeReplayState(EncodeReplayState(state), "state");
  };
  for (const double wrong : {static_cast<double>(NAN), static_cast<double>(INFINITY)}) {
    EXPECT_TRUE(refuses([=](ReplayState& state) { state.limiter.sample_credit = wrong; }));
    EXPECT_TRUE(refuses([=](ReplayState& state) { state.limiter.insert_debt = wrong; }));
    EXPECT_TRUE(refuses([=](ReplayState& state) { state.items.max_priority = wrong; }));
    EXPECT_TRUE(refuses([=](ReplayState& state) {
      state.limiter_change.emplace().current = {.min_size = 1, .band = wrong};
    }));
    EXPECT_TRUE(refuses([=](ReplayState& state) { state.items.priorities[1] = static_cast<float>(wrong); }));
  }
  EXPECT_TRUE(refuses([](ReplayState& state) { state.items.priorities[0] = -0.5f; }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.limiter.inserted = INT64_MAX; }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.limiter.sampled = -1; }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.up_to.segment = UINT64_MAX; }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.sequences.Accept({1, 1, UINT64_MAX}); }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.items.chunks[0].frames = 3; }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.items.chunks[0].frames = UINT32_MAX; }));
  EXPECT_TRUE(refuses([](ReplayState& state) { state.items.priorities.pop_back(); }));
  EXPECT_FALSE(refuses([](ReplayState& state) { state.limiter.sample_credit = -64.0; }));
}

TEST(StateFile, IsReadUpToTheLimitAndNotBeyondIt) {
  MemoryFolder folder;
  const auto file = folder.path() / "state";
  ASSERT_TRUE(WriteReplayState(file, {}));
  const uint64_t bytes = std::filesystem::file_size(file);
  EXPECT_TRUE(ReadReplayState(file, bytes));
  const auto longer = ReadReplayState(file, bytes - 1);
  ASSERT_FALSE(longer);
  EXPECT_EQ(longer.error().code, ErrorCode::kCorrupt);
  // Sparse: what is never allocated costs nothing either.
  std::filesystem::resize_file(file, uint64_t{1} << 40);
  EXPECT_EQ(ReadReplayState(file, MaxStateBytes(0)).error().code, ErrorCode::kCorrupt);
}

// Why no state is longer than MaxStateBytes: whatever is added to it was added to its segments, and is longer
// there; the rest is bounded.
TEST(StateFile, IsNeverWrittenLongerThanItIsRead) {
  const uint64_t empty = EncodeReplayState({}).size();
  for (uint32_t frames = 1; frames <= kMaxChunkFrames; ++frames) {
    ReplayState state;
    state.items.chunks = {{1, 1, frames}};
    state.items.priorities.resize(frames);
    state.items.times_sampled.resize(frames);
    const uint64_t columns = frames * (4 + sizeof(Action) + 4 + 1) + (frames + 1) * 4;
    const uint64_t shortest = kChunkHeaderBytes + columns + frames * 1 + 8;
    EXPECT_LE(EncodeReplayState(state).size() - empty, Segment::RecordBytes(shortest)) << frames;
  }
  ReplayState full;
  full.limiter_change.emplace();
  for (uint32_t actor = 0; actor < SequenceTable::kMaxActors; ++actor) {
    for (uint64_t incarnation = 1; incarnation <= SequenceTable::kMaxIncarnations; ++incarnation) {
      full.sequences.Accept({actor, incarnation, 1});
    }
  }
  constexpr uint64_t kSegments = uint64_t{1} << 45;
  const std::vector<std::byte> bytes = EncodeReplayState(full);
  EXPECT_LE(bytes.size() + kSegments, MaxStateBytes(kSegments));
  EXPECT_TRUE(DecodeReplayState(bytes, "state"));
}

}  // namespace
}  // namespace dadrl
