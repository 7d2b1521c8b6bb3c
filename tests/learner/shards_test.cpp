// The learner's fetcher with real replay processes: two shards.
#include <gtest/gtest.h>

#include <array>

#include "common/dds/node.h"
#include "learner/batch_fetcher.h"
#include "tests/common/io/test_run_key.h"
#include "tests/replay/service/peer_actor.h"
#include "tests/replay/service/replay_process.h"

namespace dadrl {
namespace {

constexpr int kBatch = 16;
constexpr Duration kPatience = std::chrono::seconds(30);

class ShardsTest : public testing::Test {
 protected:
  ShardsTest() {
    config_.observation.vehicles = kTestSpec.vehicles;
    config_.observation.history = kTestSpec.history;
    config_.algorithm.n_step = 1;
    config_.algorithm.batch_size = kBatch;
    config_.learner.credits = 2;
    config_.replay.shards = 2;
    config_.replay.min_size = 8;
    config_.replay.samples_per_insert = 0.0;
    config_.cluster.port = dds::FindFreePort().value();
    for (int shard = 0; shard < 2; ++shard) {
      replays_[static_cast<size_t>(shard)] =
          std::make_unique<ReplayProcess>(folder_.path() / "run", config_, shard);
      replays_[static_cast<size_t>(shard)]->Start();
    }
    learner_node_ = dds::Node::Create(config_.cluster, 2, dds::Role::kLearner, 0, kTestRunKey).value();
    fetcher_ =
        BatchFetcher::Create(*learner_node_, config_, {kBatch}, 77, [] { return 1u; }, clock_, {}).value();
    fetcher_->Start();
  }
  // Actor `shard` + 1 fills its shard with episodes of four frames.
  void Fill(int shard, int episodes) {
    const auto id = static_cast<uint32_t>(shard + 1);
    const auto node = dds::Node::Create(config_.cluster, 2, dds::Role::kActor, shard, kTestRunKey).value();
    PeerActor actor(*node, id, 100, shard);
    for (int i = 1; i <= episodes; ++i) actor.Add({.episode = static_cast<uint64_t>(i), .end = kTerminated});
    ASSERT_TRUE(actor.PumpUntilStored(static_cast<uint64_t>(episodes)));
  }
  // Takes `count` batches; how many came from each shard. Fewer when they stop coming.
  std::array<int, 2> Take(int count) {
    std::array<int, 2> from{};
    for (int i = 0; i < count; ++i) {
      TrajectoryBatch* batch = fetcher_->Take(kPatience);
      if (batch == nullptr) break;
      ++from[batch->rewards[0] < TestReward(2, 0, 0) ? 0 : 1];
      fetcher_->Release(batch);
    }
    return from;
  }

  TemporaryFolder folder_;
  Config config_;
  std::array<std::unique_ptr<ReplayProcess>, 2> replays_;
  std::unique_ptr<dds::Node> learner_node_;
  const SystemClock clock_;
  std::unique_ptr<BatchFetcher> fetcher_;
};

TEST_F(ShardsTest, SamplesFollowWhatEachHoldsAndLosingOneStopsNothing) {
  Fill(0, 25);
  Fill(1, 75);
  Take(20);  // until both have said what they hold
  const auto both = Take(200);
  ASSERT_EQ(both[0] + both[1], 200);
  EXPECT_NEAR(both[1], 150, 10);
  replays_[1]->Kill();
  Take(10);  // those that were under way
  const auto alone = Take(100);
  EXPECT_EQ(alone[0], 100);
  replays_[1]->Start();
  EXPECT_TRUE(Eventually([&] { return Take(5)[1] > 0; })) << replays_[1]->Log();
}

TEST_F(ShardsTest, AShardThatWasStoppedForLongServesAgainAndRefusesNothing) {
  fetcher_.reset();
  fetcher_ = BatchFetcher::Create(*learner_node_, config_, {kBatch}, 78, [] { return 1u; }, clock_,
                                  {.request_timeout = std::chrono::milliseconds(5)})
                 .value();
  fetcher_->Start();
  Fill(0, 25);
  Fill(1, 25);
  ASSERT_TRUE(Eventually([&] { return Take(5)[1] > 0; }));
  const uint64_t before = fetcher_->stats().given_up;
  replays_[1]->Stop();
  // Far more than it would keep, and than its reader holds.
  ASSERT_TRUE(Eventually([&] { return Take(1)[0] == 1 && fetcher_->stats().given_up > before + 200; }));
  replays_[1]->Continue();
  EXPECT_TRUE(Eventually([&] { return Take(5)[1] > 0; })) << replays_[1]->Log();
  EXPECT_TRUE(fetcher_->status()) << fetcher_->status().error().message;
}

TEST_F(ShardsTest, AShardWithoutActorsHoldsUpNobodyAndJoinsWhenItHasSome) {
  Fill(0, 25);
  EXPECT_EQ(Take(100), (std::array{100, 0}));
  Fill(1, 25);
  EXPECT_TRUE(Eventually([&] { return Take(5)[1] > 0; }));
  const auto both = Take(100);
  EXPECT_NEAR(both[1], 50, 10);
}

}  // namespace
}  // namespace dadrl
