// What a restart finds: after a clean stop, after kill -9, with other options.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "tests/common/util/captured_log.h"
#include "tests/replay/table_recovery_fixture.h"

namespace dadrl {
namespace {

TEST_F(TableRecovery, WithoutACleanStopEverythingIsThereOnce) {
  std::map<float, std::vector<float>> before;
  {
    auto table = Open();
    Store(*table, 1, 9);
  }
  for (int restart = 0; restart < 3; ++restart) {
    auto table = Open();
    EXPECT_EQ(table->Stored(1, 7), 9u);
    EXPECT_EQ(table->Insert(Build(ChunkOf(9))), Insertion::kDuplicate);
    EXPECT_EQ(table->stats().inserted_frames, 45u);
    const auto slices = SampleAll(*table);
    EXPECT_EQ(slices.size(), 43u);  // the last two frames' slices are not complete
    if (restart > 0) {
      EXPECT_EQ(slices, before);
    }
    before = slices;
  }
  auto table = Open();
  EXPECT_EQ(table->Insert(Build(ChunkOf(10))), Insertion::kStored);
  EXPECT_EQ(SampleAll(*table).size(), 50u) << "the open episode goes on across the restart";
}

TEST_F(TableRecovery, SequencesOfDroppedSegmentsAreRemembered) {
  TableOptions options = Options(folder_.path());
  options.replay.max_disk_bytes = 20000;
  uint64_t last = 0;
  {
    auto table = Open(options);
    ASSERT_EQ(table->Insert(Build({.identity = {2, 3, 1}, .end = kTerminated})), Insertion::kStored);
    while (table->stats().frames_held == table->stats().inserted_frames) {
      ASSERT_EQ(table->Insert(Build(ChunkOf(++last))), Insertion::kStored);
    }
  }
  auto table = Open(options);
  EXPECT_EQ(table->Stored(2, 3), 1u);
  EXPECT_EQ(table->Insert(Build({.identity = {2, 3, 1}, .end = kTerminated})), Insertion::kDuplicate);
  EXPECT_EQ(table->stats().inserted_frames, 4 + last * 5);
  EXPECT_EQ(table->Insert(Build(ChunkOf(1))), Insertion::kDuplicate);
}

TEST_F(TableRecovery, ACleanStopRestoresTheCounters) {
  {
    auto table = Open();
    Store(*table, 1, 4);
    ASSERT_TRUE(table->Sample({7, 1}, 0));
    ASSERT_TRUE(table->SaveState());
  }
  auto table = Open();
  EXPECT_EQ(table->stats().sampled, 7u);
  EXPECT_EQ(table->stats().inserted_frames, 20u);
}

TEST_F(TableRecovery, StoredRewardsThatTheTaskCannotGiveAreDroppedWithACount) {
  TableOptions any = Options(folder_.path());
  any.bounds.reward = INFINITY;  // as replays that did not look have stored them
  {
    auto table = Open(any);
    Store(*table, 1, 2);
    TestChunk huge = ChunkOf(3);
    huge.last_reward = 1e30f;
    ASSERT_EQ(table->Insert(Build(huge)), Insertion::kStored);
    huge = ChunkOf(4);
    huge.last_reward = 3e38f;
    ASSERT_EQ(table->Insert(Build(huge)), Insertion::kStored);
    Store(*table, 5, 6);
  }
  const CapturedLog log;
  auto table = Open();
  EXPECT_EQ(table->stats().frames_held, 20u);
  EXPECT_THAT(log.text(), testing::HasSubstr("and 2 unusable chunks"));
  for (const auto& [first, rewards] : SampleAll(*table)) {
    for (const float reward : rewards) EXPECT_LE(std::abs(reward), 5.56f);
  }
  EXPECT_EQ(table->Stored(1, 7), 6u) << "the actor goes on behind them";
}

TEST_F(TableRecovery, WhatAnotherTaskCouldGiveStaysOnDisk) {
  TableOptions any = Options(folder_.path());
  any.bounds.reward = INFINITY;
  TestChunk huge = ChunkOf(1);
  huge.last_reward = 100.0f;
  ASSERT_EQ(Open(any)->Insert(Build(huge)), Insertion::kStored);
  EXPECT_EQ(Open()->stats().frames_held, 0u);
  EXPECT_EQ(Open(any)->stats().frames_held, 5u);
}

// Key and probability of everything that is sampled in proportion to its priority.
std::map<float, float> Probabilities(ReplayTable& table) {
  std::map<float, float> probabilities;
  while (probabilities.size() < table.stats().items) {
    const auto batch = table.Sample({64, 1}, 0).value();
    for (const SampledTrajectory& item : batch.trajectories)
      probabilities[item.steps[0].reward] = item.probability;
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
    auto table = Open(options);
    Store(*table, 1, 4);
    const auto batch = table->Sample({200, 1}, 0).value();
    for (const SampledTrajectory& item : batch.trajectories) {
      table->UpdatePriorities({{item.key}}, {{1.0f + static_cast<float>(item.key % 7)}});
    }
    before = Probabilities(*table);
    ASSERT_TRUE(table->SaveState());
  }
  {
    auto table = Open(options);
    EXPECT_EQ(Probabilities(*table), before);
    // Stored, but not in the state file: as after kill -9.
    ASSERT_TRUE(table->Insert(Build(ChunkOf(5))));
    ASSERT_TRUE(table->Insert(Build(ChunkOf(6))));
  }
  auto table = Open(options);
  const auto after = Probabilities(*table);
  ASSERT_EQ(after.size(), 30u);
  float highest = 0.0f;
  for (const auto& [reward, probability] : after) highest = std::max(highest, probability);
  const float scale = after.begin()->second / before.begin()->second;
  for (const auto& [reward, probability] : before) EXPECT_FLOAT_EQ(after.at(reward), scale * probability);
  for (uint32_t frame = 0; frame < 10; ++frame) EXPECT_EQ(after.at(TestReward(1, 3, frame)), highest);
}

TEST_F(TableRecovery, PrioritiesBeyondTheBoundCountAsTheBound) {
  TableOptions options = Options(folder_.path());
  options.replay.sampler = SamplerKind::kPrioritized;
  options.replay.priority_exponent = 1.0;
  options.replay.max_times_sampled = 0;
  options.bounds.priority = INFINITY;
  {
    auto table = Open(options);
    Store(*table, 1, 2);
    const auto batch = table->Sample({1, 1}, 0).value();
    table->UpdatePriorities({{batch.trajectories[0].key}}, {{3e38f}});
    ASSERT_TRUE(table->SaveState());
  }
  options.bounds.priority = 4.0;
  auto table = Open(options);
  const auto probabilities = Probabilities(*table);
  EXPECT_EQ(probabilities.size(), 10u);
  float highest = 0.0f;
  for (const auto& [reward, probability] : probabilities) highest = std::max(highest, probability);
  EXPECT_NEAR(highest, 4.0f / (4.0f + 9 * 1.0f), 1e-6f);
}

TEST_F(TableRecovery, WhatWasSampledOftenEnoughOrRemovedStaysAway) {
  TableOptions options = Options(folder_.path());
  options.replay.max_times_sampled = 2;
  options.replay.max_items = 15;
  options.replay.remover = SamplerKind::kNewestFirst;
  {
    auto table = Open(options);
    Store(*table, 1, 4);
    ASSERT_EQ(table->stats().items, 15u);
    ASSERT_TRUE(table->Sample({21, 1}, 0));
    ASSERT_TRUE(table->SaveState());
  }
  auto table = Open(options);
  EXPECT_EQ(table->stats().frames_held, 20u);
  std::map<float, int> left;
  const auto batch = table->Sample({9, 1}, 0).value();
  for (const SampledTrajectory& item : batch.trajectories) ++left[item.steps[0].reward];
  EXPECT_EQ(table->stats().items, 0u) << "15 items, twice each: 21 samples before, 9 after";
  for (const auto& [reward, count] : left) EXPECT_LE(count, 2) << reward;
}

TEST_F(TableRecovery, TheStalenessLimitHoldsAtOnceAfterARestart) {
  TableOptions options = Options(folder_.path());
  options.replay.max_staleness = 5;
  options.replay.max_times_sampled = 0;
  {
    auto table = Open(options);
    TestChunk chunk = ChunkOf(1);
    chunk.end = kTerminated;
    ASSERT_TRUE(table->Insert(Build(chunk)));
    EXPECT_FALSE(table->Sample({1, 1}, 100));
    ASSERT_TRUE(table->SaveState());
  }
  EXPECT_EQ(Open(options)->stats().items, 0u);
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
  EXPECT_EQ(Open(options)->limiter_options(), LimiterOptions(options.replay));
}

TEST_F(TableRecovery, AStateFileInTheMiddleOfASegmentCountsNothingTwice) {
  {
    auto table = Open();
    for (uint64_t sequence = 1; sequence <= 6; ++sequence) {
      ASSERT_TRUE(table->Insert(Build(ChunkOf(sequence))));
      if (sequence == 3) {
        ASSERT_TRUE(table->SaveState());
      }
    }
  }
  EXPECT_EQ(Open()->stats().inserted_frames, 30u);
}

TEST_F(TableRecovery, AnotherObservationIsRefusedAndNothingIsTouched) {
  {
    auto table = Open();
    ASSERT_TRUE(table->Insert(Build(ChunkOf(1))));
  }
  TableOptions other = Options(folder_.path());
  other.spec = DrivingShape{.vehicles = 9, .history = 1};
  const auto refused = ReplayTable::Open(other, clock_);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kCorrupt);
  EXPECT_EQ(Open()->stats().frames_held, 5u);
}

TEST_F(TableRecovery, ASmallerBoundDropsTheOldestAtTheStart) {
  {
    auto table = Open();
    Store(*table, 1, 400);
  }
  TableOptions smaller = Options(folder_.path());
  smaller.replay.max_disk_bytes = 140000;
  auto table = Open(smaller);
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
