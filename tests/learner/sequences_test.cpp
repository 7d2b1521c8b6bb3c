// Sequences from actors to a recurrent learner, through real replay processes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

#include "common/dds/node.h"
#include "learner/batch_fetcher.h"
#include "tests/common/io/test_run_key.h"
#include "tests/driving_columns.h"
#include "tests/replay/service/peer_actor.h"
#include "tests/replay/service/replay_process.h"

namespace dadrl {
namespace {

constexpr int kLength = 5;
constexpr int kBatch = 16;
constexpr int kShards = 2;
constexpr Duration kPatience = std::chrono::seconds(30);

struct Episode {
  uint32_t frames = 0;
  uint8_t end = 0;  // 0: still open
};

class SequencesOverDdsTest : public testing::Test {
 protected:
  SequencesOverDdsTest() {
    config_.observation.vehicles = kTestSpec.vehicles;
    config_.observation.history = kTestSpec.history;
    config_.algorithm.n_step = 1;
    config_.algorithm.batch_size = kBatch;
    config_.learner.credits = 2;
    config_.replay.shards = kShards;
    config_.replay.min_size = 2;
    config_.replay.samples_per_insert = 0.0;
    config_.replay.sequence_length = kLength;
    config_.replay.sequence_period = 2;
    config_.cluster.port = dds::FindFreePort().value();
  }
  void Launch() {
    for (int shard = 0; shard < kShards; ++shard) {
      auto& replay = replays_[static_cast<size_t>(shard)];
      replay = std::make_unique<ReplayProcess>(folder_.path() / "run", config_, shard);
      replay->Start();
    }
    node_ = dds::Node::Create(config_.cluster, kShards, dds::Role::kLearner, 0, kTestRunKey).value();
  }
  std::unique_ptr<BatchFetcher> Fetcher(const Config& config) const {
    auto fetcher =
        BatchFetcher::Create(*node_, config, {kBatch, kLength, true}, 77, [] { return 1u; }, clock_, {})
            .value();
    fetcher->Start();
    return fetcher;
  }
  // Actor `shard` + 1 drives episodes of 1 to 17 decisions and sends them in chunks of 1 to 4: most sequences
  // cross a border between chunks. The final frame of a truncated episode sometimes is a chunk of its own;
  // the last episode stays open.
  void Drive(int shard, int episodes) {
    const auto id = static_cast<uint32_t>(shard + 1);
    Random random(id);
    const auto node =
        dds::Node::Create(config_.cluster, kShards, dds::Role::kActor, shard, kTestRunKey).value();
    PeerActor actor(*node, id, 100, shard);
    for (int number = 1; number <= episodes; ++number) {
      const uint8_t end = number == episodes ? 0 : random.Uniform() < 0.5 ? kTerminated : kTruncated;
      const auto episode = static_cast<uint64_t>(number);
      const auto frames = static_cast<uint32_t>(1 + random.Below(17));
      driven_[{id, episode}] = {frames, end};
      AddEpisode(actor, episode, {frames, end}, random);
    }
    ASSERT_TRUE(actor.PumpUntilStored(actor.produced()));
  }
  static void AddEpisode(PeerActor& actor, uint64_t number, const Episode& episode, Random& random) {
    for (uint32_t frame = 0; frame < episode.frames;) {
      const auto left = static_cast<int>(episode.frames - frame);
      TestChunk chunk{.episode = number,
                      .first_frame = frame,
                      .frames = std::min(left, static_cast<int>(1 + random.Below(4))),
                      .policy_version = static_cast<uint32_t>(number)};
      frame += static_cast<uint32_t>(chunk.frames);
      const bool last = frame == episode.frames;
      const bool truncated = last && episode.end == kTruncated;
      const bool final_apart = random.Uniform() < 0.5;
      if (last) chunk.end = episode.end;
      chunk.final_frame = truncated && !final_apart;
      actor.Add(chunk);
      if (truncated && final_apart) {
        actor.Add({.episode = number, .first_frame = frame, .frames = 0, .final_frame = true});
      }
    }
  }
  // Every place where a sequence may start, as the reward that stands there.
  std::set<float> Starts() const {
    std::set<float> starts;
    for (const auto& [which, episode] : driven_) {
      for (uint32_t frame = 0; frame < episode.frames; frame += 2) {
        // Of an open episode those with a whole sequence and the observation behind it.
        const bool whole = episode.end != 0 || frame + kLength < episode.frames;
        if (whole) starts.insert(TestReward(which.first, which.second, frame));
      }
    }
    return starts;
  }
  // Compares sequence `i` with what was driven, frame by frame. Returns its first reward.
  float Check(const TrajectoryBatch& batch, size_t i) const {
    const float first = batch.rewards[i];
    const auto value = static_cast<uint64_t>(first / kTestScale);
    const auto actor = static_cast<uint32_t>(value / 10000);
    const uint64_t number = value % 10000 / 100;
    const auto start = static_cast<uint32_t>(value % 100);
    const auto found = driven_.find({actor, number});
    if (found == driven_.end()) return ADD_FAILURE() << "never driven: " << first, first;
    const Episode& episode = found->second;
    const auto steps = static_cast<int>(std::min<uint32_t>(kLength, episode.frames - start));
    const bool at_end = start + static_cast<uint32_t>(steps) == episode.frames;
    EXPECT_EQ(batch.steps[i], steps);
    EXPECT_EQ(batch.terminated[i], at_end && episode.end == kTerminated);
    EXPECT_EQ(batch.truncated[i], at_end && episode.end == kTruncated);
    for (int t = 0; t <= kLength; ++t) {
      const size_t row = static_cast<size_t>(t) * batch.steps.size() + i;
      const bool there = t < steps || (t == steps && !batch.terminated[i]);
      const float wanted = there ? TestReward(actor, number, start + static_cast<uint32_t>(t)) : 0.0f;
      EXPECT_EQ(EgoOf(batch.observations)[row * 20 + 1], wanted);
      if (t == kLength) continue;
      const size_t step = row;
      EXPECT_EQ(batch.rewards[step], t < steps ? wanted : 0.0f);
      EXPECT_EQ(batch.decisions[0][2 * step], t < steps ? 0.5f : 0.0f);
      EXPECT_EQ(batch.policy_versions[step], t < steps ? number : 0u);
    }
    return first;
  }

  TemporaryFolder folder_;
  Config config_;
  std::array<std::unique_ptr<ReplayProcess>, kShards> replays_;
  const SystemClock clock_;
  std::unique_ptr<dds::Node> node_;
  std::map<std::pair<uint32_t, uint64_t>, Episode> driven_;
};

TEST_F(SequencesOverDdsTest, ArriveFrameByFrameAsTheyWereDrivenAndEndWithTheirEpisodes) {
  Launch();
  const auto fetcher = Fetcher(config_);
  for (int shard = 0; shard < kShards; ++shard) Drive(shard, 20);
  std::set<float> missing = Starts();
  int ends[3] = {};  // whole, terminated, truncated
  ASSERT_TRUE(Eventually([&] {
    TrajectoryBatch* batch = fetcher->Take(kPatience);
    if (batch == nullptr) return true;
    for (size_t i = 0; i < kBatch; ++i) {
      missing.erase(Check(*batch, i));
      ++ends[batch->terminated[i] ? 1 : batch->truncated[i] ? 2 : 0];
    }
    fetcher->Release(batch);
    return missing.empty() || HasFailure();
  })) << missing.size()
      << " sequences never came";
  EXPECT_TRUE(missing.empty());
  for (const int count : ends) EXPECT_GT(count, 0);
  EXPECT_EQ(fetcher->stats().corrupt, 0u);
}

TEST_F(SequencesOverDdsTest, GoOnWhenAShardIsKilledAndComesBack) {
  Launch();
  const auto fetcher = Fetcher(config_);
  for (int shard = 0; shard < kShards; ++shard) Drive(shard, 20);
  const auto from = [&](uint32_t actor) {
    TrajectoryBatch* batch = fetcher->Take(kPatience);
    if (batch == nullptr) return false;
    const float first = Check(*batch, 0);
    fetcher->Release(batch);
    return first >= TestReward(actor, 0, 0) && first < TestReward(actor + 1, 0, 0);
  };
  EXPECT_TRUE(Eventually([&] { return from(2); }));
  replays_[1]->Kill();
  for (int i = 0; i < 10; ++i) from(0);  // those that were under way
  for (int i = 0; i < 50; ++i) EXPECT_TRUE(from(1));
  replays_[1]->Start();
  EXPECT_TRUE(Eventually([&] { return from(2); })) << replays_[1]->Log();
}

TEST_F(SequencesOverDdsTest, AReplayWithoutThemRefusesTheLearnerWithTheReason) {
  const Config recurrent = config_;
  config_.replay.sequence_length = 0;
  config_.replay.sequence_period = 1;
  Launch();
  const auto fetcher = Fetcher(recurrent);
  ASSERT_TRUE(Eventually([&] { return !fetcher->status(); }));
  EXPECT_EQ(fetcher->status().error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(fetcher->status().error().message,
              testing::HasSubstr("trajectories of 5 steps with all observations; this replay was "
                                 "started with replay.sequence_length 0"));
}

TEST_F(SequencesOverDdsTest, EachKindNeedsAReplayThatServesIt) {
  node_ = dds::Node::Create(config_.cluster, kShards, dds::Role::kLearner, 0, kTestRunKey).value();
  const auto newest = [] { return 1u; };
  const auto transitions = BatchFetcher::Create(*node_, config_, {kBatch}, 77, newest, clock_, {});
  ASSERT_FALSE(transitions);
  EXPECT_EQ(transitions.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(transitions.error().message, testing::HasSubstr("replay.sequence_period: 2"));
  config_.replay.sequence_length = 0;
  const auto sequences =
      BatchFetcher::Create(*node_, config_, {kBatch, kLength, true}, 77, newest, clock_, {});
  ASSERT_FALSE(sequences);
  EXPECT_EQ(sequences.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(sequences.error().message, testing::HasSubstr("replay.sequence_length: 0"));
}

}  // namespace
}  // namespace dadrl
