// What a restart finds: after a clean stop, after kill -9, after damage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>

#include "replay/table.h"
#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

using Insertion = ReplayTable::Insertion;

TableOptions Options(const std::filesystem::path& directory) {
  TableOptions options{.directory = directory, .schema = SchemaHash(kTestSpec), .replay = {}, .n_step = 2};
  options.replay.min_size = 1;
  options.replay.samples_per_insert = 0.0;
  options.replay.max_disk_bytes = 1 << 20;
  options.replay.segment_bytes = 1 << 16;
  options.replay.max_times_sampled = 1;
  return options;
}

TestChunk ChunkOf(uint64_t sequence) {
  // Episodes of two chunks, the second of which ends it.
  const bool second = sequence % 2 == 0;
  return {.identity = {1, 7, sequence},
          .episode = (sequence + 1) / 2,
          .first_frame = second ? 5u : 0u,
          .frames = 5,
          .end = static_cast<uint8_t>(second ? kTerminated : 0)};
}

// Every slice in the table as first reward -> its rewards; draws everything.
std::map<float, std::vector<float>> DrawAll(ReplayTable& table) {
  std::map<float, std::vector<float>> slices;
  const size_t items = table.stats().items;
  if (items == 0) return slices;
  const auto batch = table.Sample(items, 2, 0).value();
  for (const SampledItem& item : batch.items) {
    EXPECT_EQ(Decode(item.first), item.rewards[0]);
    const bool inserted =
        slices.try_emplace(item.rewards[0], item.rewards.begin(), item.rewards.end()).second;
    EXPECT_TRUE(inserted) << "frame " << item.rewards[0] << " is there twice";
  }
  return slices;
}

std::filesystem::path OnlySegment(const std::filesystem::path& directory) {
  std::filesystem::path found;
  for (const auto& entry : std::filesystem::directory_iterator(directory)) {
    if (entry.path().filename().string().starts_with("segment-")) found = entry.path();
  }
  return found;
}

class TableRecovery : public testing::Test {
 protected:
  std::unique_ptr<ReplayTable> Open() { return ReplayTable::Open(Options(folder_.path()), clock_).value(); }

  SystemClock clock_;
  TemporaryFolder folder_;
};

TEST_F(TableRecovery, WithoutACleanStopEverythingIsThereOnce) {
  std::map<float, std::vector<float>> before;
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 9; ++sequence) {
      ASSERT_EQ(table->Insert(Build(ChunkOf(sequence))), Insertion::kStored);
    }
  }
  for (int restart = 0; restart < 3; ++restart) {
    auto table = Open();
    EXPECT_EQ(table->Stored(1, 7), 9u);
    EXPECT_EQ(table->Insert(Build(ChunkOf(9))), Insertion::kDuplicate);
    EXPECT_EQ(table->stats().inserted_frames, 45u);
    const auto slices = DrawAll(*table);
    EXPECT_EQ(slices.size(), 43u);  // the last two frames' slices are not complete
    if (restart > 0) {
      EXPECT_EQ(slices, before);
    }
    before = slices;
  }
  auto table = Open();
  EXPECT_EQ(table->Insert(Build(ChunkOf(10))), Insertion::kStored);
  EXPECT_EQ(DrawAll(*table).size(), 50u) << "the open episode goes on across the restart";
}

TEST_F(TableRecovery, SequencesOfDroppedSegmentsAreRemembered) {
  TableOptions options = Options(folder_.path());
  options.replay.max_disk_bytes = 20000;
  uint64_t last = 0;
  {
    auto table = ReplayTable::Open(options, clock_).value();
    ASSERT_EQ(table->Insert(Build({.identity = {2, 3, 1}, .end = kTerminated})), Insertion::kStored);
    while (table->stats().frames_held == table->stats().inserted_frames) {
      ASSERT_EQ(table->Insert(Build(ChunkOf(++last))), Insertion::kStored);
    }
  }
  auto table = ReplayTable::Open(options, clock_).value();
  EXPECT_EQ(table->Stored(2, 3), 1u);
  EXPECT_EQ(table->Insert(Build({.identity = {2, 3, 1}, .end = kTerminated})), Insertion::kDuplicate);
  EXPECT_EQ(table->stats().inserted_frames, 4 + last * 5);
  EXPECT_EQ(table->Insert(Build(ChunkOf(1))), Insertion::kDuplicate);
}

TEST_F(TableRecovery, ACleanStopRestoresTheCounters) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 4; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
    ASSERT_TRUE(table->Sample(7, 1, 0));
    ASSERT_TRUE(table->SaveState());
  }
  auto table = Open();
  EXPECT_EQ(table->stats().sampled, 7u);
  EXPECT_EQ(table->stats().inserted_frames, 20u);
}

// Key and probability of everything that is drawn in proportion to its priority.
std::map<float, float> Probabilities(ReplayTable& table) {
  std::map<float, float> probabilities;
  while (probabilities.size() < table.stats().items) {
    const auto batch = table.Sample(64, 1, 0).value();
    for (const SampledItem& item : batch.items) probabilities[item.rewards[0]] = item.probability;
  }
  return probabilities;
}

TEST_F(TableRecovery, PrioritiesSurviveAndWhatCameLaterStartsAtTheHighest) {
  TableOptions options = Options(folder_.path());
  options.replay.sampler = SamplerKind::kPrioritized;
  options.replay.priority_exponent = 1.0;
  options.replay.max_times_sampled = 0;
  std::map<float, float> before;
  {
    auto table = ReplayTable::Open(options, clock_).value();
    for (uint64_t sequence = 1; sequence <= 4; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
    const auto batch = table->Sample(200, 1, 0).value();
    for (const SampledItem& item : batch.items) {
      table->UpdatePriorities({{item.key}}, {{1.0f + static_cast<float>(item.key % 7)}});
    }
    before = Probabilities(*table);
    ASSERT_TRUE(table->SaveState());
  }
  {
    auto table = ReplayTable::Open(options, clock_).value();
    EXPECT_EQ(Probabilities(*table), before);
    // Stored, but not in the state file: as after kill -9.
    ASSERT_TRUE(table->Insert(Build(ChunkOf(5))));
    ASSERT_TRUE(table->Insert(Build(ChunkOf(6))));
  }
  auto table = ReplayTable::Open(options, clock_).value();
  const auto after = Probabilities(*table);
  ASSERT_EQ(after.size(), 30u);
  float highest = 0.0f;
  for (const auto& [reward, probability] : after) highest = std::max(highest, probability);
  const float scale = after.begin()->second / before.begin()->second;
  for (const auto& [reward, probability] : before) EXPECT_FLOAT_EQ(after.at(reward), scale * probability);
  for (uint32_t frame = 0; frame < 10; ++frame) EXPECT_EQ(after.at(TestReward(1, 3, frame)), highest);
}

TEST_F(TableRecovery, WhatWasSampledOftenEnoughOrRemovedStaysAway) {
  TableOptions options = Options(folder_.path());
  options.replay.max_times_sampled = 2;
  options.replay.max_items = 15;
  options.replay.remover = SamplerKind::kNewestFirst;
  {
    auto table = ReplayTable::Open(options, clock_).value();
    for (uint64_t sequence = 1; sequence <= 4; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
    ASSERT_EQ(table->stats().items, 15u);
    ASSERT_TRUE(table->Sample(21, 1, 0));
    ASSERT_TRUE(table->SaveState());
  }
  auto table = ReplayTable::Open(options, clock_).value();
  EXPECT_EQ(table->stats().frames_held, 20u);
  std::map<float, int> left;
  const auto batch = table->Sample(9, 1, 0).value();
  for (const SampledItem& item : batch.items) ++left[item.rewards[0]];
  EXPECT_EQ(table->stats().items, 0u) << "15 items, twice each: 21 draws before, 9 after";
  for (const auto& [reward, count] : left) EXPECT_LE(count, 2) << reward;
}

TEST_F(TableRecovery, TheStalenessLimitHoldsAtOnceAfterARestart) {
  TableOptions options = Options(folder_.path());
  options.replay.max_staleness = 5;
  options.replay.max_times_sampled = 0;
  {
    auto table = ReplayTable::Open(options, clock_).value();
    TestChunk chunk = ChunkOf(1);
    chunk.end = kTerminated;
    ASSERT_TRUE(table->Insert(Build(chunk)));
    EXPECT_FALSE(table->Sample(1, 1, 100));
    ASSERT_TRUE(table->SaveState());
  }
  EXPECT_EQ(ReplayTable::Open(options, clock_).value()->stats().items, 0u);
}

TEST_F(TableRecovery, LimiterBoundsThatWereSetWhileRunningHoldUntilTheConfigurationChanges) {
  const RateLimiter::Options slower{.min_size = 7, .max_samples_per_insert = 2.0};
  {
    auto table = Open();
    table->Reconfigure(slower);
    ASSERT_TRUE(table->SaveState());
  }
  EXPECT_EQ(Open()->limiter_options(), slower);
  TableOptions options = Options(folder_.path());
  options.replay.samples_per_insert = 4.0;
  EXPECT_EQ(ReplayTable::Open(options, clock_).value()->limiter_options(), LimiterOptions(options.replay));
}

TEST_F(TableRecovery, AStateFileInTheMiddleOfASegmentCountsNothingTwice) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 6; ++sequence) {
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
      if (sequence == 3) ASSERT_TRUE(table->SaveState());
    }
  }
  EXPECT_EQ(Open()->stats().inserted_frames, 30u);
}

TEST_F(TableRecovery, ADamagedStateFileCostsOnlyTheCounters) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 4; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
    ASSERT_TRUE(table->SaveState());
  }
  std::ofstream(folder_.path() / "state", std::ios::trunc) << "nonsense";
  auto table = Open();
  EXPECT_EQ(table->Stored(1, 7), 4u);
  EXPECT_EQ(table->stats().items, 20u);
}

TEST_F(TableRecovery, TruncatedAtAnyByteItHoldsTheWholeChunksAndGoesOn) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 3; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
  }
  const auto path = OnlySegment(folder_.path());
  std::ifstream file(path, std::ios::binary);
  const std::string whole(std::istreambuf_iterator<char>(file), {});
  for (size_t length = 0; length <= whole.size(); length += 1) {
    TemporaryFolder folder;
    std::ofstream(folder.path() / path.filename(), std::ios::binary) << whole.substr(0, length);
    auto table = ReplayTable::Open(Options(folder.path()), clock_).value();
    const uint64_t stored = table->Stored(1, 7).value_or(0);
    ASSERT_EQ(table->stats().frames_held, stored * 5) << length;
    // What the actor sends again goes on exactly there.
    for (uint64_t sequence = 1; sequence <= 4; ++sequence) {
      ASSERT_EQ(table->Insert(Build(ChunkOf(sequence)), 1),
                sequence <= stored ? Insertion::kDuplicate : Insertion::kStored);
    }
    ASSERT_EQ(DrawAll(*table).size(), 20u) << length;
  }
}

TEST_F(TableRecovery, ADamagedRecordCostsItsChunkAndNothingElse) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 6; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
  }
  const auto path = OnlySegment(folder_.path());
  const auto size = std::filesystem::file_size(path);
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(size / 2));
  file << "XXXX";
  file.close();
  auto table = Open();
  EXPECT_EQ(table->stats().frames_held, 25u);
  EXPECT_EQ(table->Stored(1, 7), 6u);
  for (const auto& [first, rewards] : DrawAll(*table)) {
    // No slice bridges the hole.
    if (rewards.size() == 2) {
      EXPECT_EQ(rewards[1], first + 1.0f);
    }
  }
}

TEST_F(TableRecovery, HundredsOfRandomDamagesCostTheirChunksAndNothingElse) {
  constexpr uint64_t kChunks = 300;
  constexpr int kCases = 400;
  TableOptions options = Options(folder_.path() / "whole");
  std::map<uint64_t, std::vector<std::byte>> chunks;
  {
    const auto table = ReplayTable::Open(options, clock_).value();
    for (uint64_t sequence = 1; sequence <= kChunks; ++sequence) {
      chunks[sequence] = Build(ChunkOf(sequence));
      ASSERT_EQ(table->Insert(chunks[sequence]), Insertion::kStored);
    }
  }
  Random random(400);
  for (int damage = 0; damage < kCases; ++damage) {
    options.directory = folder_.path() / "damaged";
    std::filesystem::remove_all(options.directory);
    std::filesystem::copy(folder_.path() / "whole", options.directory);
    std::vector<std::filesystem::path> segments;
    for (const auto& entry : std::filesystem::directory_iterator(options.directory)) {
      if (entry.path().filename().string().starts_with("segment-")) segments.push_back(entry.path());
    }
    ASSERT_GE(segments.size(), 2u);
    std::sort(segments.begin(), segments.end());
    const auto& victim = segments[random.Below(segments.size())];
    const uint64_t size = std::filesystem::file_size(victim);
    const uint64_t flips = random.Below(4);
    for (uint64_t i = 0; i < flips; ++i) {
      std::fstream file(victim, std::ios::in | std::ios::out | std::ios::binary);
      const auto at = static_cast<std::streamoff>(random.Below(size));
      file.seekg(at);
      const auto byte = static_cast<char>(file.get() ^ (1 << random.Below(8)));
      file.seekp(at);
      file.put(byte);
    }
    const uint64_t cut = flips == 0 ? 1 + random.Below(size) : 0;
    if (cut > 0) std::filesystem::resize_file(victim, size - cut);

    SegmentLog::Recovery recovery;
    std::map<uint64_t, int> found;
    const auto log = SegmentLog::Open(
        {options.directory, options.schema},
        [&](const auto&, std::span<const std::byte> record) {
          const auto chunk = ChunkView::Parse(record);
          if (!chunk) return false;
          const uint64_t sequence = chunk->header().identity.sequence;
          EXPECT_TRUE(
              std::equal(record.begin(), record.end(), chunks[sequence].begin(), chunks[sequence].end()));
          ++found[sequence];
          return true;
        },
        recovery);
    ASSERT_TRUE(log) << log.error().message;
    for (const auto& [sequence, copies] : found) EXPECT_EQ(copies, 1) << sequence;
    const uint64_t record = Segment::RecordBytes(chunks[1].size());
    const uint64_t lost = cut > 0 ? cut / (record - 64) + 1 : flips;
    EXPECT_GE(found.size() + lost, kChunks) << "case " << damage;
  }
}

TEST_F(TableRecovery, AnotherObservationIsRefusedAndNothingIsTouched) {
  {
    auto table = Open();
    ASSERT_TRUE(table->Insert(Build(ChunkOf(1))));
  }
  TableOptions other = Options(folder_.path());
  other.schema = SchemaHash({.vehicles = 9, .history = 1});
  const auto refused = ReplayTable::Open(other, clock_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(Open()->stats().frames_held, 5u);
}

TEST_F(TableRecovery, ASmallerBoundDropsTheOldestAtTheStart) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 400; ++sequence)
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
  }
  TableOptions smaller = Options(folder_.path());
  smaller.replay.max_disk_bytes = 140000;
  auto table = ReplayTable::Open(smaller, clock_).value();
  EXPECT_LE(table->stats().disk_bytes, 140000u);
  EXPECT_GT(table->stats().frames_held, 0u);
  EXPECT_EQ(table->Stored(1, 7), 400u);
}

TEST_F(TableRecovery, AFolderThatCannotBeMadeIsOneClearError) {
  std::ofstream(folder_.path() / "file") << "x";
  const auto refused = ReplayTable::Open(Options(folder_.path() / "file" / "replay"), clock_);
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message, testing::HasSubstr("file"));
  EXPECT_THAT(refused.error().message, testing::Not(testing::HasSubstr("\n")));
}

}  // namespace
}  // namespace dadrl
