// Over memory, on a clock of the test's: fetcher and shards take turns.
#include "learner/batch_fetcher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "common/port/memory_transport.h"
#include "proto/trajectory_codec.h"
#include "tests/common/util/eventually.h"
#include "tests/driving_columns.h"
#include "tests/learner/cluster_fixture.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;

constexpr uint64_t kIncarnation = 77;
constexpr int kBatchSize = 16;
constexpr TrajectoryShape kShape{.count = kBatchSize, .steps = 2};

class BatchFetcherTest : public testing::Test {
 protected:
  BatchFetcherTest() {
    clock_.Advance(1h);
    config_.algorithm.batch_size = kBatchSize;
    config_.learner.credits = 2;
  }
  // Time-outs far away, so that only the tests about them see one.
  void MakeFetcher(FetchOptions options = {.request_timeout = 60s, .corrupt_pause = 20ms}) {
    fetcher_ = BatchFetcher::Create(
                   transport_, config_, kShape, kIncarnation, [] { return 9u; }, clock_, options)
                   .value();
  }
  std::unique_ptr<TestShard> MakeShard(int index = 0) {
    return std::make_unique<TestShard>(transport_, index);
  }
  std::vector<std::byte> Batch(uint64_t first_key) const { return maker_.Make(kBatchSize, first_key); }
  // What the shard hears when the fetcher had its turn.
  std::vector<dadrl_idl_BatchRequest> Requests(TestShard& shard) {
    fetcher_->Step();
    return shard.TakeRequests();
  }
  // Of one that is there already.
  TrajectoryBatch* Take() {
    fetcher_->Step();
    return fetcher_->Take(Duration::zero());
  }

  Config config_;
  const BatchMaker maker_{DrivingShape{}};
  ManualClock clock_;
  const MemoryTransport transport_{clock_};
  std::unique_ptr<BatchFetcher> fetcher_;
};

TEST_F(BatchFetcherTest, AsksForWhatTheConfigurationSaysAndDecodesTheReply) {
  config_.learner.credits = 1;
  MakeFetcher();
  const auto shard = MakeShard();
  const auto requests = Requests(*shard);
  ASSERT_EQ(requests.size(), 1u);
  const dadrl_idl_BatchRequest& request = requests[0];
  EXPECT_EQ(request.learner, kIncarnation);
  EXPECT_EQ(request.trajectories, static_cast<uint32_t>(kBatchSize));
  EXPECT_EQ(request.steps, static_cast<uint32_t>(kShape.steps));
  EXPECT_FALSE(request.all_observations);
  EXPECT_EQ(request.schema, SchemaHash(DrivingShape{}));
  EXPECT_EQ(request.policy_version, 9u);
  ASSERT_TRUE(shard->Reply(kIncarnation, request.request, Batch(500)));
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->keys[3], 503u);
  EXPECT_EQ(batch->rewards[0], 1.0f);
  EXPECT_EQ(batch->rewards[kBatchSize], 0.5f);
  EXPECT_EQ(fetcher_->stats().bytes, Batch(500).size());
  EXPECT_EQ(fetcher_->stats().frames_held, 1000u);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, PrefetchesUpToTheCreditsWhileNothingIsTaken) {
  MakeFetcher();
  const auto shard = MakeShard();
  const auto requests = Requests(*shard);
  ASSERT_EQ(requests.size(), 2u);
  for (const auto& request : requests) {
    ASSERT_TRUE(shard->Reply(kIncarnation, request.request, Batch(1)));
  }
  EXPECT_TRUE(Requests(*shard).empty());
  EXPECT_TRUE(Requests(*shard).empty()) << "both credits stand for a batch that waits";
  EXPECT_EQ(fetcher_->stats().batches, 2u);
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(Requests(*shard).size(), 1u) << "while that one is trained on";
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, ReusesTheMemoryOfAFewBatches) {
  MakeFetcher();
  const auto shard = MakeShard();
  std::set<const float*> memory;
  for (int taken = 0; taken < 40; ++taken) {
    for (const auto& request : Requests(*shard)) {
      ASSERT_TRUE(shard->Reply(kIncarnation, request.request, Batch(1)));
    }
    TrajectoryBatch* batch = Take();
    ASSERT_NE(batch, nullptr);
    memory.insert(VehiclesOf(batch->observations).data());
    fetcher_->Release(batch);
  }
  EXPECT_LE(memory.size(), 3u);
}

TEST_F(BatchFetcherTest, GoesOnWhenTheReplayIsRestarted) {
  MakeFetcher();
  auto shard = MakeShard();
  const auto before = Requests(*shard);
  ASSERT_EQ(before.size(), 2u);
  shard.reset();
  fetcher_->Step();
  EXPECT_EQ(fetcher_->waiting_for(), Activity::kWaitForReplay);
  shard = MakeShard();
  const auto after = Requests(*shard);
  ASSERT_EQ(after.size(), 2u);
  EXPECT_EQ(after[0].request, before[0].request);
  EXPECT_EQ(after[1].request, before[1].request);
  ASSERT_TRUE(shard->Reply(kIncarnation, after[1].request, Batch(1)));
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, AsksAgainWhenAReplyIsLost) {
  config_.learner.credits = 1;
  MakeFetcher({.request_timeout = 200ms});
  const auto shard = MakeShard();
  const auto first = Requests(*shard);
  ASSERT_EQ(first.size(), 1u);
  clock_.Advance(100ms);
  EXPECT_TRUE(Requests(*shard).empty());
  clock_.Advance(100ms);
  const auto again = Requests(*shard);
  ASSERT_EQ(again.size(), 1u);
  EXPECT_EQ(again[0].request, first[0].request);
  EXPECT_EQ(fetcher_->stats().repeated, 1u);
}

TEST_F(BatchFetcherTest, DropsGarbageAndAsksForAnotherBatch) {
  config_.learner.credits = 1;
  MakeFetcher();
  const auto shard = MakeShard();
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
    const auto requests = Requests(*shard);
    ASSERT_EQ(requests.size(), 1u);
    ASSERT_TRUE(shard->Reply(kIncarnation, requests[0].request, bytes));
    EXPECT_EQ(Take(), nullptr);
    EXPECT_EQ(fetcher_->stats().corrupt, ++dropped);
    EXPECT_TRUE(Requests(*shard).empty()) << "not in a tight loop";
    clock_.Advance(20ms);
  }
  const auto requests = Requests(*shard);
  ASSERT_EQ(requests.size(), 1u);
  ASSERT_TRUE(shard->Reply(kIncarnation, requests[0].request, Batch(900)));
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->keys[0], 900u);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, IgnoresRepliesToOthersAndToOldRequests) {
  config_.learner.credits = 1;
  MakeFetcher();
  const auto shard = MakeShard();
  const uint64_t request = Requests(*shard).at(0).request;
  ASSERT_TRUE(shard->Reply(kIncarnation - 1, request, Batch(100)));     // the learner before this one
  ASSERT_TRUE(shard->Reply(kIncarnation, request, Batch(200), 5));      // no such shard
  ASSERT_TRUE(shard->Reply(kIncarnation, request + 1000, Batch(300)));  // never asked
  ASSERT_TRUE(shard->Reply(kIncarnation, request, Batch(400)));
  ASSERT_TRUE(shard->Reply(kIncarnation, request, Batch(500)));  // answered before
  for (int i = 0; i < 5; ++i) fetcher_->Step();
  EXPECT_EQ(fetcher_->stats().stale, 2u);
  EXPECT_EQ(fetcher_->stats().foreign, 2u);
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  EXPECT_EQ(batch->keys[0], 400u);
  EXPECT_EQ(fetcher_->Take(Duration::zero()), nullptr);
  EXPECT_EQ(fetcher_->stats().batches, 1u);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, SaysWhatItWaitsFor) {
  MakeFetcher();
  EXPECT_EQ(fetcher_->waiting_for(), Activity::kWaitForReplay);
  const auto shard = MakeShard();
  const auto requests = Requests(*shard);
  ASSERT_EQ(requests.size(), 2u);
  EXPECT_EQ(fetcher_->waiting_for(), Activity::kWaitForBatch);
  for (const auto& request : requests) ASSERT_TRUE(shard->Reply(kIncarnation, request.request, {}));
  for (int i = 0; i < 2; ++i) fetcher_->Step();
  EXPECT_EQ(fetcher_->waiting_for(), Activity::kWaitForInserts);
  // A withheld request is answered in the end, under its number.
  ASSERT_TRUE(shard->Reply(kIncarnation, requests[0].request, Batch(1)));
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, StopsAndSaysWhyWhenAShardRefusesToServeIt) {
  MakeFetcher();
  const auto shard = MakeShard();
  const auto requests = Requests(*shard);
  ASSERT_EQ(requests.size(), 2u);
  ASSERT_TRUE(shard->Reply(kIncarnation, requests[0].request, Batch(1)));
  ASSERT_TRUE(shard->Refuse(kIncarnation, requests[1].request, "trajectories of 3 steps"));
  fetcher_->Step();
  ASSERT_FALSE(fetcher_->status());
  EXPECT_EQ(fetcher_->status().error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(fetcher_->status().error().message, testing::HasSubstr("replay 0 refuses"));
  EXPECT_THAT(fetcher_->status().error().message, testing::HasSubstr("trajectories of 3 steps"));
  // What came before can still be trained on.
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  fetcher_->Release(batch);
  EXPECT_EQ(Take(), nullptr);
  EXPECT_TRUE(shard->TakeRequests().empty());
}

TEST_F(BatchFetcherTest, SendsPrioritiesToTheShardThatTheBatchCameFrom) {
  config_.replay.shards = 2;
  MakeFetcher();
  const auto first = MakeShard(0);
  const auto second = MakeShard(1);
  ASSERT_TRUE(second->Reply(kIncarnation, Requests(*second).at(0).request, Batch(40)));
  TrajectoryBatch* batch = Take();
  ASSERT_NE(batch, nullptr);
  std::vector<float> errors(kBatchSize);
  for (size_t i = 0; i < errors.size(); ++i) errors[i] = 0.5f * static_cast<float>(i);
  fetcher_->UpdatePriorities(*batch, errors);
  fetcher_->Step();
  int updates = 0;
  second->priorities().Take(10, [&](const dadrl_idl_PriorityUpdate& update) {
    ++updates;
    EXPECT_EQ(update.shard, 1u);
    EXPECT_EQ(update.learner, kIncarnation);
    EXPECT_EQ(std::vector(update.keys._buffer, update.keys._buffer + update.keys._length), batch->keys);
    EXPECT_EQ(std::vector(update.priorities._buffer, update.priorities._buffer + update.priorities._length),
              errors);
  });
  EXPECT_EQ(updates, 1);
  fetcher_->Release(batch);
}

TEST_F(BatchFetcherTest, StartedItFetchesAndSendsPrioritiesByItself) {
  const MemoryTransport transport;
  const SystemClock clock;
  TestShard shard(transport, 0);
  const auto fetcher =
      BatchFetcher::Create(transport, config_, kShape, kIncarnation, [] { return 9u; }, clock, {}).value();
  fetcher->Start();
  TrajectoryBatch* batch = nullptr;
  ASSERT_TRUE(Eventually([&] {
    for (const auto& request : shard.TakeRequests()) {
      EXPECT_TRUE(shard.Reply(kIncarnation, request.request, Batch(1)));
    }
    return (batch = fetcher->Take(1ms)) != nullptr;
  }));
  fetcher->UpdatePriorities(*batch, std::vector<float>(kBatchSize, 1.0f));
  EXPECT_TRUE(shard.priorities().Wait(30s));
  fetcher->Release(batch);
}

}  // namespace
}  // namespace dadrl
