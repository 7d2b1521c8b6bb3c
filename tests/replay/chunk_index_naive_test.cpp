// The index beside a replay that looks at everything each time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "tests/replay/chunk_index_fixture.h"

namespace dadrl {
namespace {

// What an episode-wise look at everything stored says should be sampleable.
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
      auto flags = static_cast<uint8_t>(action ? kHasDecision : 0);
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
      if ((frames[at].flags & kHasDecision) == 0) break;
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
      std::multiset<NaiveReplay::Slice> sampled;
      if (!expected.empty()) {
        for (const SampledTrajectory& item : f.Sample(expected.size(), n_step).trajectories) {
          sampled.insert({Decode(item.payloads.front()), RewardsOf(item),
                          item.terminated ? std::nullopt : std::optional(Decode(item.payloads.back())),
                          item.terminated});
        }
      }
      ASSERT_EQ(sampled, expected) << n_step << " " << seed;
    }
  }
}

}  // namespace
}  // namespace dadrl
