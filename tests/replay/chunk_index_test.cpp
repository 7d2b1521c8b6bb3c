#include "replay/chunk_index.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "tests/replay/test_chunks.h"

namespace dadrl {
namespace {

// An index over segments in memory.
class IndexFixture {
 public:
  explicit IndexFixture(const ChunkIndex::Options& options) : index(options) { NewSegment(); }

  void NewSegment() { segments.push_back(Segment::Create({}, segments.size() + 1, 1, 1 << 24).value()); }
  void Add(const TestChunk& chunk) {
    const auto stored = segments.back()->Append(Build(chunk)).value();
    index.Add(segments.back(), ChunkView::Parse(stored).value());
  }
  SampledBatch Draw(size_t count, int n_step) {
    auto batch = AssembleBatch(index.Draw(count, n_step, random), n_step);
    EXPECT_TRUE(batch) << batch.error().message;
    return std::move(*batch);
  }

  std::vector<std::shared_ptr<Segment>> segments;
  ChunkIndex index;
  Random random{1};
};

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
  for (const SampledItem& item : f.Draw(2, 2).items) {
    EXPECT_FALSE(item.terminated);
    EXPECT_EQ(Decode(item.next), TestReward(1, 1, 2));
    EXPECT_EQ(item.rewards.size(), Decode(item.first) == TestReward(1, 1, 0) ? 2u : 1u);
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
  for (const SampledItem& item : f.Draw(5, 2).items) firsts.insert(Decode(item.first));
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

TEST(ChunkIndex, AnItemIsDrawnAtMostSoOften) {
  IndexFixture f({.n_step = 1, .max_times_sampled = 3});
  f.Add({.identity = {1, 1, 1}, .frames = 10, .end = kTerminated});
  EXPECT_TRUE(f.index.CanDraw(30));
  EXPECT_FALSE(f.index.CanDraw(31));
  std::map<uint64_t, int> counts;
  for (const SampledItem& item : f.Draw(20, 1).items) ++counts[item.key];
  for (const SampledItem& item : f.Draw(10, 1).items) ++counts[item.key];
  EXPECT_EQ(counts.size(), 10u);
  for (const auto& [key, count] : counts) EXPECT_EQ(count, 3);
  EXPECT_EQ(f.index.items(), 0u);
  EXPECT_FALSE(f.index.CanDraw(1));
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

TEST(ChunkIndex, PrioritiesSteerTheDrawAndWeightsUndoIt) {
  IndexFixture f({.n_step = 1,
                  .sampler = SamplerKind::kPrioritized,
                  .priority_exponent = 1.0,
                  .importance_exponent = 0.5});
  f.Add({.identity = {1, 1, 1}, .frames = 4, .end = kTerminated});
  std::map<float, uint64_t> keys;
  while (keys.size() < 4) {
    for (const SampledItem& item : f.Draw(8, 1).items) keys[Decode(item.first)] = item.key;
  }
  const uint64_t favourite = keys[TestReward(1, 1, 2)];
  for (const auto& [reward, key] : keys) f.index.UpdatePriority(key, key == favourite ? 9.0 : 1.0);
  f.index.UpdatePriority(favourite, NAN);
  f.index.UpdatePriority(favourite, -1.0);
  f.index.UpdatePriority(0, 100.0);
  f.index.UpdatePriority(~uint64_t{0}, 100.0);
  f.index.UpdatePriority(favourite | 63, 100.0);
  int hits = 0;
  const SampledBatch batch = f.Draw(4000, 1);
  for (const SampledItem& item : batch.items) {
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
  f.index.UpdatePriority(f.Draw(1, 1).items[0].key, 4.0);
  f.Add({.identity = {1, 1, 2}, .episode = 2, .frames = 1, .end = kTerminated});
  EXPECT_NEAR(f.Draw(1, 1).items[0].probability, 0.5, 1e-6);
}

// What an episode-wise look at everything stored says should be drawable.
class NaiveReplay {
 public:
  struct Frame {
    size_t segment;
    float observation;
    float reward;
    uint8_t flags;
    bool breaks_before;  // does not continue the frame before it in its list
  };
  using Slice =
      std::tuple<float, std::vector<float>, std::optional<float>, bool>;  // first, rewards, next, end

  void Add(const TestChunk& chunk, size_t segment) {
    auto& frames = streams_[chunk.identity.actor];
    auto& position = positions_[chunk.identity.actor];
    const std::tuple wanted{chunk.identity.incarnation, chunk.episode, chunk.first_frame};
    const int total = chunk.frames + (chunk.final_frame ? 1 : 0);
    for (int i = 0; i < total; ++i) {
      const uint32_t number = chunk.first_frame + static_cast<uint32_t>(i);
      const bool action = i < chunk.frames;
      auto flags = static_cast<uint8_t>(action ? kHasAction : 0);
      if (i + 1 == chunk.frames) flags = static_cast<uint8_t>(flags | chunk.end);
      const float value = TestReward(chunk.identity.actor, chunk.episode, number);
      frames.push_back({segment, value, value, flags, i == 0 && wanted != position});
    }
    position = {chunk.identity.incarnation, chunk.episode, chunk.first_frame + static_cast<uint32_t>(total)};
  }
  void DropBefore(size_t segment) {
    for (auto& [actor, frames] : streams_) {
      std::erase_if(frames, [&](const Frame& frame) { return frame.segment < segment; });
    }
  }
  std::multiset<Slice> Slices(int n_step) const {
    std::multiset<Slice> slices;
    for (const auto& [actor, frames] : streams_) {
      for (size_t i = 0; i < frames.size(); ++i) {
        if (const auto slice = SliceAt(frames, i, n_step)) slices.insert(*slice);
      }
    }
    return slices;
  }

 private:
  static std::optional<Slice> SliceAt(const std::vector<Frame>& frames, size_t at, int n_step) {
    Slice slice{frames[at].observation, {}, std::nullopt, false};
    for (int step = 0; step < n_step; ++step, ++at) {
      if ((frames[at].flags & kHasAction) == 0) break;
      std::get<1>(slice).push_back(frames[at].reward);
      if ((frames[at].flags & kTerminated) != 0) {
        std::get<3>(slice) = true;
        return slice;
      }
      if (at + 1 >= frames.size() || frames[at + 1].breaks_before) return std::nullopt;
    }
    if (std::get<1>(slice).empty()) return std::nullopt;
    std::get<2>(slice) = frames[at].observation;
    return slice;
  }

  std::map<uint32_t, std::vector<Frame>> streams_;
  std::map<uint32_t, std::tuple<uint64_t, uint64_t, uint32_t>> positions_;
};

// An actor that lives a random life: episodes of all lengths and ends, chunks of all sizes, crashes.
struct RandomActor {
  uint32_t id;
  uint64_t incarnation = 1;
  uint64_t sequence = 0;
  uint64_t episode = 1;
  uint32_t frame = 0;
  bool awaits_final = false;

  TestChunk Next(Random& random) {
    if (random.Uniform() < 0.03) {
      ++incarnation;
      sequence = 0;
      Finish();
    }
    TestChunk chunk{.identity = {id, incarnation, ++sequence}, .episode = episode, .first_frame = frame};
    if (awaits_final) {
      chunk.frames = 0;
      chunk.final_frame = true;
      Finish();
      return chunk;
    }
    chunk.frames = static_cast<int>(1 + random.Below(random.Uniform() < 0.5 ? 3 : 9));
    frame += static_cast<uint32_t>(chunk.frames);
    const double fate = random.Uniform();
    if (fate < 0.15) {
      chunk.end = kTerminated;
      Finish();
    } else if (fate < 0.3) {
      chunk.end = kTruncated;
      chunk.final_frame = random.Uniform() < 0.5;
      awaits_final = !chunk.final_frame;
      if (chunk.final_frame) Finish();
    } else if (fate < 0.35) {
      Finish();  // lost to the simulator
    }
    return chunk;
  }
  void Finish() {
    ++episode;
    frame = 0;
    awaits_final = false;
  }
};

TEST(ChunkIndex, HoldsExactlyTheSlicesThatANaiveReplayFinds) {
  for (const int n_step : {1, 2, 3, 7, 32}) {
    for (uint64_t seed = 0; seed < 20; ++seed) {
      Random random(DeriveSeed(seed, static_cast<uint64_t>(n_step)));
      IndexFixture f({.n_step = n_step, .max_times_sampled = 1});
      NaiveReplay naive;
      std::vector<RandomActor> actors{{1}, {2}, {3}};
      for (int i = 0; i < 150; ++i) {
        const TestChunk chunk = actors[random.Below(actors.size())].Next(random);
        f.Add(chunk);
        naive.Add(chunk, f.segments.size());
        if (random.Uniform() < 0.06) f.NewSegment();
      }
      if (f.segments.size() > 2) {
        const size_t keep_from = 1 + random.Below(f.segments.size());
        f.index.DropSegmentsBefore(keep_from);
        naive.DropBefore(keep_from);
      }
      const auto expected = naive.Slices(n_step);
      ASSERT_EQ(f.index.items(), expected.size()) << n_step << " " << seed;
      std::multiset<NaiveReplay::Slice> drawn;
      if (!expected.empty()) {
        for (const SampledItem& item : f.Draw(expected.size(), n_step).items) {
          drawn.insert({Decode(item.first),
                        {item.rewards.begin(), item.rewards.end()},
                        item.next.empty() ? std::nullopt : std::optional(Decode(item.next)),
                        item.terminated});
        }
      }
      ASSERT_EQ(drawn, expected) << n_step << " " << seed;
    }
  }
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
    std::set<uint64_t> drawn;
    for (const SampledItem& item : f.Draw(400, 1).items) drawn.insert(item.key);
    std::set<uint64_t> expected;
    for (const Entry& kept : naive) expected.insert(kept.key);
    ASSERT_EQ(drawn, expected) << episode;
  }
  EXPECT_EQ(f.index.frames(), 100u) << "what is not drawn any more is still stored";
}

TEST(ChunkIndex, AStrideMakesItemsOfEveryFewFramesOnly) {
  IndexFixture f({.n_step = 4, .stride = 3, .max_times_sampled = 1});
  f.Add({.identity = {1, 1, 1}, .frames = 5});
  f.Add({.identity = {1, 1, 2}, .first_frame = 5, .frames = 5, .end = kTerminated});
  std::set<float> starts;
  for (const SampledItem& item : f.Draw(4, 4).items) starts.insert(item.rewards[0]);
  EXPECT_EQ(starts, (std::set<float>{TestReward(1, 1, 0), TestReward(1, 1, 3), TestReward(1, 1, 6),
                                     TestReward(1, 1, 9)}));
  EXPECT_EQ(f.index.items(), 0u);
}

TEST(ChunkIndex, ADrawnBatchOutlivesItsSegment) {
  IndexFixture f({.n_step = 2});
  f.Add({.identity = {1, 1, 1}, .frames = 6, .end = kTerminated});
  DrawnItems drawn = f.index.Draw(10, 2, f.random);
  f.index.DropSegmentsBefore(99);
  f.segments.clear();
  const auto batch = AssembleBatch(std::move(drawn), 2);
  ASSERT_TRUE(batch);
  for (const SampledItem& item : batch->items) EXPECT_EQ(Decode(item.first), item.rewards[0]);
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
