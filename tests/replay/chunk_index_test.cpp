#include "replay/chunk_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "tests/replay/chunk_index_fixture.h"

namespace dadrl {
namespace {

TEST(ChunkIndex, AFrameBecomesAnItemWhenItsSliceIsComplete) {
  IndexFixture f({.n_step = 3});
  f.Add({.identity = {1, 1, 1}, .frames = 3});
  EXPECT_EQ(f.index.items(), 0u);
  f.Add({.identity = {1, 1, 2}, .first_frame = 3, .frames = 1});
  EXPECT_EQ(f.index.items(), 1u);
  f.Add({.identity = {1, 1, 3}, .first_frame = 4, .frames = 2});
  EXPECT_EQ(f.index.items(), 3u);
  f.Add({.identity = {1, 1, 4}, .first_frame = 6, .frames = 1, .end = kTerminated});
  EXPECT_EQ(f.index.items(), 7u);
}

TEST(ChunkIndex, ATruncatedEpisodeCompletesWithItsFinalFrameEvenInAChunkOfItsOwn) {
  IndexFixture f({.n_step = 2, .max_times_sampled = 1});
  f.Add({.identity = {1, 1, 1}, .frames = 2, .end = kTruncated});
  EXPECT_EQ(f.index.items(), 0u);
  f.Add({.identity = {1, 1, 2}, .first_frame = 2, .frames = 0, .final_frame = true});
  ASSERT_EQ(f.index.items(), 2u);
  for (const SampledTrajectory& item : f.Sample(2, 2).trajectories) {
    EXPECT_FALSE(item.terminated);
    EXPECT_EQ(Decode(item.payloads.back()), TestReward(1, 1, 2));
    EXPECT_EQ(item.steps.size(), Decode(item.payloads.front()) == TestReward(1, 1, 0) ? 2u : 1u);
  }
}

TEST(ChunkIndex, AnEpisodeThatBreaksOffKeepsItsLastFramesToItself) {
  IndexFixture f({.n_step = 2});
  f.Add({.identity = {1, 1, 1}, .frames = 5});
  EXPECT_EQ(f.index.items(), 3u);
  f.Add({.identity = {1, 2, 1}, .frames = 5});  // the actor was restarted
  EXPECT_EQ(f.index.items(), 6u);
  f.Add({.identity = {1, 2, 2}, .first_frame = 6, .frames = 3});  // a frame is missing
  EXPECT_EQ(f.index.items(), 7u);
  f.Add({.identity = {1, 2, 3}, .episode = 2, .frames = 3});
  EXPECT_EQ(f.index.items(), 8u);
}

TEST(ChunkIndex, NothingFollowsATruncationButItsFinalFrame) {
  IndexFixture f({.n_step = 2});
  f.Add({.identity = {1, 1, 1}, .frames = 3, .end = kTruncated});
  EXPECT_EQ(f.index.items(), 1u);
  f.Add({.identity = {1, 1, 2}, .first_frame = 3, .frames = 3});
  EXPECT_EQ(f.index.items(), 2u);
}

TEST(ChunkIndex, DroppingASegmentTakesItsItemsAndLeavesTheRestOfTheEpisode) {
  IndexFixture f({.n_step = 2, .max_times_sampled = 1});
  f.Add({.identity = {1, 1, 1}, .frames = 4});
  f.NewSegment();
  f.Add({.identity = {1, 1, 2}, .first_frame = 4, .frames = 4});
  EXPECT_EQ(f.index.items(), 6u);
  EXPECT_EQ(f.index.frames(), 8u);
  f.index.DropSegmentsBefore(2);
  EXPECT_EQ(f.index.items(), 2u);
  EXPECT_EQ(f.index.frames(), 4u);
  f.Add({.identity = {1, 1, 3}, .first_frame = 8, .frames = 1, .end = kTerminated});
  EXPECT_EQ(f.index.items(), 5u);
  std::set<float> firsts;
  for (const SampledTrajectory& item : f.Sample(5, 2).trajectories)
    firsts.insert(Decode(item.payloads.front()));
  EXPECT_EQ(firsts.size(), 5u);
  EXPECT_EQ(*firsts.begin(), TestReward(1, 1, 4));
}

TEST(ChunkIndex, DroppingTheSegmentOfAnOpenEpisodeEndsIt) {
  IndexFixture f({.n_step = 3});
  f.Add({.identity = {1, 1, 1}, .frames = 2});
  f.NewSegment();
  f.index.DropSegmentsBefore(2);
  f.Add({.identity = {1, 1, 2}, .first_frame = 2, .frames = 4});
  EXPECT_EQ(f.index.items(), 1u);
}

TEST(ChunkIndex, AnItemIsSampledAtMostSoOften) {
  IndexFixture f({.n_step = 1, .max_times_sampled = 3});
  f.Add({.identity = {1, 1, 1}, .frames = 10, .end = kTerminated});
  EXPECT_TRUE(f.index.CanSample(30));
  EXPECT_FALSE(f.index.CanSample(31));
  std::map<uint64_t, int> counts;
  for (const SampledTrajectory& item : f.Sample(20, 1).trajectories) ++counts[item.key];
  for (const SampledTrajectory& item : f.Sample(10, 1).trajectories) ++counts[item.key];
  EXPECT_EQ(counts.size(), 10u);
  for (const auto& [key, count] : counts) EXPECT_EQ(count, 3);
  EXPECT_EQ(f.index.items(), 0u);
  EXPECT_FALSE(f.index.CanSample(1));
}

TEST(ChunkIndex, StaleItemsLeaveAndStaleFramesNeverEnter) {
  IndexFixture f({.n_step = 1, .max_staleness = 10});
  f.Add({.identity = {1, 1, 1}, .frames = 5, .end = kTerminated, .policy_version = 5});
  f.Add({.identity = {1, 1, 2}, .episode = 2, .frames = 5, .end = kTerminated, .policy_version = 12});
  f.index.SetNewestVersion(15);
  EXPECT_EQ(f.index.items(), 10u);
  f.index.SetNewestVersion(16);
  EXPECT_EQ(f.index.items(), 5u);
  f.Add({.identity = {1, 1, 3}, .episode = 3, .frames = 5, .end = kTerminated, .policy_version = 5});
  EXPECT_EQ(f.index.items(), 5u);
  f.index.SetNewestVersion(3);  // an old learner's word
  f.Add({.identity = {1, 1, 4}, .episode = 4, .frames = 5, .end = kTerminated, .policy_version = 6});
  EXPECT_EQ(f.index.items(), 10u);
}

TEST(ChunkIndex, PrioritiesSteerTheSampleAndWeightsUndoIt) {
  IndexFixture f({.n_step = 1,
                  .sampler = SamplerKind::kPrioritized,
                  .priority_exponent = 1.0,
                  .importance_exponent = 0.5});
  f.Add({.identity = {1, 1, 1}, .frames = 4, .end = kTerminated});
  std::map<float, uint64_t> keys;
  while (keys.size() < 4) {
    for (const SampledTrajectory& item : f.Sample(8, 1).trajectories)
      keys[Decode(item.payloads.front())] = item.key;
  }
  const uint64_t favourite = keys[TestReward(1, 1, 2)];
  for (const auto& [reward, key] : keys) f.index.UpdatePriority(key, key == favourite ? 9.0 : 1.0);
  f.index.UpdatePriority(favourite, NAN);
  f.index.UpdatePriority(favourite, -1.0);
  f.index.UpdatePriority(0, 100.0);
  f.index.UpdatePriority(~uint64_t{0}, 100.0);
  f.index.UpdatePriority(favourite | 63, 100.0);
  int hits = 0;
  const SampledBatch batch = f.Sample(4000, 1);
  for (const SampledTrajectory& item : batch.trajectories) {
    const bool hit = item.key == favourite;
    hits += hit;
    ASSERT_NEAR(item.probability, hit ? 0.75 : 1.0 / 12.0, 1e-6);
    ASSERT_NEAR(item.importance_weight, hit ? 1.0 / 3.0 : 1.0, 1e-6);
  }
  EXPECT_NEAR(hits / 4000.0, 0.75, 0.03);
}

TEST(ChunkIndex, NewItemsStartAtTheHighestPrioritySoFar) {
  IndexFixture f({.n_step = 1, .sampler = SamplerKind::kPrioritized, .priority_exponent = 1.0});
  f.Add({.identity = {1, 1, 1}, .frames = 1, .end = kTerminated});
  f.index.UpdatePriority(f.Sample(1, 1).trajectories[0].key, 4.0);
  f.Add({.identity = {1, 1, 2}, .episode = 2, .frames = 1, .end = kTerminated});
  EXPECT_NEAR(f.Sample(1, 1).trajectories[0].probability, 0.5, 1e-6);
}

class Removers : public testing::TestWithParam<SamplerKind> {};
INSTANTIATE_TEST_SUITE_P(Kinds, Removers,
                         testing::Values(SamplerKind::kOldestFirst, SamplerKind::kNewestFirst,
                                         SamplerKind::kHighestPriority, SamplerKind::kLowestPriority));

TEST_P(Removers, TakeTheItemsThatAPlainListSays) {
  constexpr size_t kMaxItems = 20;
  IndexFixture f({.n_step = 1, .max_items = kMaxItems, .remover = GetParam()});
  struct Entry {
    uint64_t key;
    double priority;
  };
  std::vector<Entry> naive;  // in the order of their last change of priority
  std::map<uint64_t, float> first_reward;
  Random random(3);
  double highest = 1.0;
  for (uint64_t episode = 1; episode <= 100; ++episode) {
    f.Add({.identity = {1, 1, episode}, .episode = episode, .frames = 1, .end = kTerminated});
    naive.push_back({(uint64_t{1} << 26 | (episode - 1)) << 6, highest});
    f.index.RemoveSurplus(random);
    if (naive.size() > kMaxItems) {
      const auto by_priority = [](const Entry& a, const Entry& b) { return a.priority < b.priority; };
      auto leaves = naive.begin();
      if (GetParam() == SamplerKind::kNewestFirst || GetParam() == SamplerKind::kOldestFirst) {
        const auto by_age = [](const Entry& a, const Entry& b) { return a.key < b.key; };
        leaves = GetParam() == SamplerKind::kOldestFirst
                     ? std::min_element(naive.begin(), naive.end(), by_age)
                     : std::max_element(naive.begin(), naive.end(), by_age);
      } else {
        leaves = GetParam() == SamplerKind::kLowestPriority
                     ? std::min_element(naive.begin(), naive.end(), by_priority)
                     : std::max_element(naive.begin(), naive.end(), by_priority);
      }
      naive.erase(leaves);
    }
    const size_t change = random.Below(naive.size());
    Entry entry = naive[change];
    entry.priority = random.Uniform(0.0, 3.0);
    highest = std::max(highest, entry.priority);
    f.index.UpdatePriority(entry.key, entry.priority);
    naive.erase(naive.begin() + static_cast<ptrdiff_t>(change));
    naive.push_back(entry);
    ASSERT_EQ(f.index.items(), naive.size());
    std::set<uint64_t> sampled;
    for (const SampledTrajectory& item : f.Sample(400, 1).trajectories) sampled.insert(item.key);
    std::set<uint64_t> expected;
    for (const Entry& kept : naive) expected.insert(kept.key);
    ASSERT_EQ(sampled, expected) << episode;
  }
  EXPECT_EQ(f.index.frames(), 100u) << "what is not sampled any more is still stored";
}

TEST(ChunkIndex, AStrideMakesItemsOfEveryFewFramesOnly) {
  IndexFixture f({.n_step = 4, .stride = 3, .max_times_sampled = 1});
  f.Add({.identity = {1, 1, 1}, .frames = 5});
  f.Add({.identity = {1, 1, 2}, .first_frame = 5, .frames = 5, .end = kTerminated});
  std::set<float> starts;
  for (const SampledTrajectory& item : f.Sample(4, 4).trajectories) starts.insert(item.steps[0].reward);
  EXPECT_EQ(starts, (std::set<float>{TestReward(1, 1, 0), TestReward(1, 1, 3), TestReward(1, 1, 6),
                                     TestReward(1, 1, 9)}));
  EXPECT_EQ(f.index.items(), 0u);
}

TEST(ChunkIndex, ASampledBatchOutlivesItsSegment) {
  IndexFixture f({.n_step = 2});
  f.Add({.identity = {1, 1, 1}, .frames = 6, .end = kTerminated});
  SampledItems sampled = f.index.SampleItems(10, 2, f.random);
  f.index.DropSegmentsBefore(99);
  f.segments.clear();
  const auto batch = ReadTrajectories(std::move(sampled), {10, 2});
  ASSERT_TRUE(batch);
  for (const SampledTrajectory& item : batch->trajectories)
    EXPECT_EQ(Decode(item.payloads.front()), item.steps[0].reward);
}

TEST(ChunkIndex, ManyRoundsOfInsertAndDropDoNotGrowIt) {
  IndexFixture f({.n_step = 1});
  size_t peak = 0;
  for (uint64_t round = 1; round <= 200; ++round) {
    for (uint64_t i = 0; i < 5; ++i) {
      f.Add({.identity = {1, 1, round * 5 + i}, .episode = round * 5 + i, .frames = 6, .end = kTerminated});
    }
    f.NewSegment();
    if (f.segments.size() > 3) f.index.DropSegmentsBefore(f.segments.size() - 2);
    if (round == 20) peak = f.index.memory_bytes();
  }
  EXPECT_GT(peak, 0u);
  EXPECT_LE(f.index.memory_bytes(), peak);
}

}  // namespace
}  // namespace dadrl
