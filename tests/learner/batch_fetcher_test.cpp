#include "learner/batch_fetcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "proto/trajectory_codec.h"
#include "tests/driving_columns.h"
#include "tests/learner/cluster_fixture.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;

constexpr uint64_t kIncarnation = 77;
constexpr int kBatchSize = 16;
constexpr TrajectoryShape kShape{.count = kBatchSize, .steps = 2};
constexpr Duration kPatience = 20s;

class BatchFetcherTest : public testing::Test {
 protected:
  BatchFetcherTest() {
    config_.cluster = dds::LoopbackCluster();
    config_.algorithm.batch_size = kBatchSize;
    config_.learner.credits = 2;
  }
  // Time-outs far away, so that only the tests about them see one.
  void StartFetcher(FetchOptions options = {.request_timeout = 60s, .corrupt_pause = 20ms}) {
    node_ = dds::Node::Create(config_.cluster, config_.replay.shards, dds::Role::kLearner, 0).value();
    fetcher_ = BatchFetcher::Create(
                   *node_, config_, kShape, kIncarnation, [] { return 9u; }, options)
                   .value();
  }
  std::unique_ptr<TestShard> StartShard(int index = 0) {
    return std::make_unique<TestShard>(config_.cluster, config_.replay.shards, index);
  }
  std::vector<std::byte> Batch(uint64_t first_key) const { return maker_.Make(kBatchSize, first_key); }

  Config config_;
  const BatchMaker maker_{DrivingShape{}};
  std::unique_ptr<dds::Node> node_;
  std::unique_ptr<BatchFetcher> fetcher_;
};

TEST_F(BatchFetcherTest, AsksForWhatTheConfigurationSaysAndDecodesTheReply) {
  config_.learner.credits = 1;
  StartFetcher();
  const auto shard = StartShard();
  const dadrl_idl_BatchRequest request = shard->AwaitRequests(1)[0];
  EXPECT_EQ(request.learner, kIncarnation);
  EXPECT_EQ(request.trajectories, static_cast<uint32_t>(kBatchSize));
  EXPECT_EQ(request.steps, static_cast<uint32_t>(kShape.steps));
  EXPECT_FALSE(request.all_observations);
  EXPECT_EQ(request.schema, SchemaHash(DrivingShape{}));
  EXPECT_EQ(request.policy_version, 9u);
  shard->Reply(kIncarnation, request.request, Batch(500));
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->keys[3], 503u);
  EXPECT_EQ(batch->rewards[0], 1.0f);
  EXPECT_EQ(batch->rewards[kBatchSize], 0.5f);
  EXPECT_EQ(fetcher_->stats().bytes, Batch(500).size());
  EXPECT_EQ(fetcher_->stats().frames_held, 1000u);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, PrefetchesUpToTheCreditsWhileNothingIsTaken) {
  StartFetcher();
  const auto shard = StartShard();
  const auto requests = shard->AwaitRequests(2);
  EXPECT_EQ(requests.size(), 2u);
  for (const auto& request : requests) shard->Reply(kIncarnation, request.request, Batch(1));
  ASSERT_TRUE(Eventually([&] { return fetcher_->stats().batches == 2; }));
  EXPECT_TRUE(shard->TakeRequests().empty());  // both credits stand for a batch that waits
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  shard->AwaitRequests(1);  // while that one is trained on
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, ReusesTheMemoryOfAFewBatches) {
  StartFetcher();
  const auto shard = StartShard();
  std::set<const float*> memory;
  for (int taken = 0; taken < 40;) {
    for (const auto& request : shard->TakeRequests()) shard->Reply(kIncarnation, request.request, Batch(1));
    TrajectoryBatch* batch = fetcher_->Take(1ms);
    if (batch == nullptr) continue;
    ++taken;
    memory.insert(VehiclesOf(batch->observations).data());
    fetcher_->Release(batch);
  }
  EXPECT_LE(memory.size(), 3u);
}

TEST_F(BatchFetcherTest, GoesOnWhenTheReplayIsRestarted) {
  StartFetcher();
  auto shard = StartShard();
  const auto before = shard->AwaitRequests(2);
  shard.reset();
  ASSERT_TRUE(Eventually([&] { return fetcher_->waiting_for() == Activity::kWaitForReplay; }));
  shard = StartShard();
  const auto after = shard->AwaitRequests(2);
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0].request, before[0].request);
  EXPECT_EQ(after[1].request, before[1].request);
  shard->Reply(kIncarnation, after[1].request, Batch(1));
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, AsksAgainWhenAReplyIsLost) {
  config_.learner.credits = 1;
  StartFetcher({.request_timeout = 200ms});
  const auto shard = StartShard();
  const auto requests = shard->AwaitRequests(2);
  EXPECT_EQ(requests[0].request, requests[1].request);
  EXPECT_GE(fetcher_->stats().repeated, 1u);
}

TEST_F(BatchFetcherTest, DropsGarbageAndAsksForAnotherBatch) {
  config_.learner.credits = 1;
  StartFetcher();
  const auto shard = StartShard();
  Random random(8);
  std::vector<std::byte> garbage(5000);
  for (std::byte& byte : garbage) byte = static_cast<std::byte>(random.Next());
  std::vector<std::byte> damaged = Batch(1);
  damaged[damaged.size() / 2] ^= std::byte{1};
  std::vector<std::byte> cut = Batch(1);
  cut.resize(cut.size() - 9);
  const std::vector<std::byte> other_kind = EncodeTrajectories({}, {0, 5, true}, SchemaHash(DrivingShape{}));
  uint64_t dropped = 0;
  for (const std::vector<std::byte>& bytes :
       {garbage, damaged, cut, maker_.Make(kBatchSize + 1, 1), other_kind, std::vector<std::byte>(1),
        maker_.Make(kBatchSize, 1, 1, {1.0f, 1e30f}), maker_.Make(kBatchSize, 1, 1, {-3e38f, 0.0f})}) {
    shard->Reply(kIncarnation, shard->AwaitRequests(1)[0].request, bytes);
    ++dropped;
    ASSERT_TRUE(Eventually([&] { return fetcher_->stats().corrupt == dropped; }));
  }
  EXPECT_EQ(fetcher_->Take(Duration::zero()), nullptr);
  shard->Reply(kIncarnation, shard->AwaitRequests(1)[0].request, Batch(900));
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->keys[0], 900u);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, IgnoresRepliesToOthersAndToOldRequests) {
  config_.learner.credits = 1;
  StartFetcher();
  const auto shard = StartShard();
  const uint64_t request = shard->AwaitRequests(1)[0].request;
  shard->Reply(kIncarnation - 1, request, Batch(100));     // the learner before this one
  shard->Reply(kIncarnation, request, Batch(200), 5);      // no such shard
  shard->Reply(kIncarnation, request + 1000, Batch(300));  // never asked
  shard->Reply(kIncarnation, request, Batch(400));
  shard->Reply(kIncarnation, request, Batch(500));  // answered before
  ASSERT_TRUE(Eventually([&] { return fetcher_->stats().stale == 2 && fetcher_->stats().foreign == 2; }));
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->keys[0], 400u);
  EXPECT_EQ(fetcher_->Take(Duration::zero()), nullptr);
  EXPECT_EQ(fetcher_->stats().batches, 1u);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, SaysWhatItWaitsFor) {
  StartFetcher();
  EXPECT_EQ(fetcher_->waiting_for(), Activity::kWaitForReplay);
  const auto shard = StartShard();
  const auto requests = shard->AwaitRequests(2);
  EXPECT_TRUE(Eventually([&] { return fetcher_->waiting_for() == Activity::kWaitForBatch; }));
  for (const auto& request : requests) shard->Reply(kIncarnation, request.request, {});
  EXPECT_TRUE(Eventually([&] { return fetcher_->waiting_for() == Activity::kWaitForInserts; }));
  // A withheld request is answered in the end, under its number.
  shard->Reply(kIncarnation, requests[0].request, Batch(1));
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, StopsAndSaysWhyWhenAShardRefusesToServeIt) {
  StartFetcher();
  const auto shard = StartShard();
  const auto requests = shard->AwaitRequests(2);
  shard->Reply(kIncarnation, requests[0].request, Batch(1));
  shard->Refuse(kIncarnation, requests[1].request, "trajectories of 3 steps");
  ASSERT_TRUE(Eventually([&] { return !fetcher_->status(); }));
  EXPECT_EQ(fetcher_->status().error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(fetcher_->status().error().message, testing::HasSubstr("replay 0 refuses"));
  EXPECT_THAT(fetcher_->status().error().message, testing::HasSubstr("trajectories of 3 steps"));
  // What came before can still be trained on.
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  fetcher_->Release(batch);
  EXPECT_EQ(fetcher_->Take(Duration::zero()), nullptr);
}

TEST_F(BatchFetcherTest, SendsPrioritiesToTheShardThatTheBatchCameFrom) {
  config_.replay.shards = 2;
  StartFetcher();
  const auto first = StartShard(0);
  const auto second = StartShard(1);
  const dadrl_idl_BatchRequest request = second->AwaitRequests(1)[0];
  second->Reply(kIncarnation, request.request, Batch(40));
  TrajectoryBatch* batch = fetcher_->Take(kPatience);
  ASSERT_NE(batch, nullptr);
  std::vector<float> errors(kBatchSize);
  for (size_t i = 0; i < errors.size(); ++i) errors[i] = 0.5f * static_cast<float>(i);
  std::vector<uint64_t> keys;
  std::vector<float> priorities;
  // Priorities may be lost; a sender repeats them with every batch.
  ASSERT_TRUE(Eventually([&] {
    fetcher_->UpdatePriorities(*batch, errors);
    second->priorities().Wait(50ms);
    second->priorities().Take(10, [&](const dadrl_idl_PriorityUpdate& update) {
      EXPECT_EQ(update.shard, 1u);
      keys.assign(update.keys._buffer, update.keys._buffer + update.keys._length);
      priorities.assign(update.priorities._buffer, update.priorities._buffer + update.priorities._length);
    });
    return !keys.empty();
  }));
  EXPECT_EQ(keys, batch->keys);
  EXPECT_EQ(priorities, errors);
  fetcher_->Release(batch);
}

}  // namespace
}  // namespace dadrl
