#include "replay/service/batch_server.h"

#include <gmock/gmock.h>

#include <filesystem>
#include <limits>

#include "replay/storage/segment_log.h"
#include "tests/replay/service/memory_shard.h"

namespace dadrl {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr int kReaderHolds = 16;  // kBatchReplyTopic

class BatchServerTest : public MemoryShard {
 protected:
  void MakeServer() {
    OpenTable();
    server_ = BatchServer::Create(transport_, 0, *table_, clock_, [this] { ++samples_; }).value();
    learner_ = std::make_unique<PeerLearner>(transport_, 200, 1);
  }
  void Insert(int chunks) {
    for (int i = 0; i < chunks; ++i, ++inserted_) {
      const auto chunk = Build({.identity = {1, 100, inserted_}, .episode = inserted_, .end = kTerminated});
      ASSERT_EQ(table_->Insert(chunk).value(), ReplayTable::Insertion::kStored);
    }
  }
  // Turns enough for all that can be done.
  void Serve() {
    for (int turn = 0; turn < 30; ++turn) server_->Step(outgoing_);
  }
  // Whether the replies to a request so far were batches, or that it waits.
  std::vector<bool> Served(uint64_t request) {
    std::vector<bool> served;
    for (const PeerLearner::Reply& reply : learner_->RepliesTo(request))
      served.push_back(!reply.bytes.empty());
    return served;
  }

  std::unique_ptr<BatchServer> server_;
  std::unique_ptr<PeerLearner> learner_;
  BatchServer::Outgoing outgoing_;
  uint64_t inserted_ = 1;
  int samples_ = 0;
};

TEST_F(BatchServerTest, ServesRequestsInTheirOrder) {
  MakeServer();
  Insert(10);
  for (int i = 0; i < 5; ++i) learner_->Ask(32);
  Serve();
  const PeerLearner::Reply reply = learner_->RepliesTo(1).at(0);
  EXPECT_EQ(reply.frames_held, 40u);
  TrajectoryBatch batch(kTestSpec, {32});
  ASSERT_TRUE(TrajectoryDecoder(kTestSpec, kTestBounds).Decode(reply.bytes, batch));
  EXPECT_THAT(learner_->batches(), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ(server_->statistics().batches, 5u);
  EXPECT_EQ(samples_, 5);
}

TEST_F(BatchServerTest, ARequestWaitsInsideUntilThereIsEnough) {
  MakeServer();
  const uint64_t request = learner_->Ask(4);
  Serve();
  EXPECT_THAT(Served(request), ElementsAre(false)) << "it is told once that it waits";
  learner_->Ask(4, request);
  Serve();
  EXPECT_THAT(Served(request), ElementsAre(false, false)) << "who asks again hears again";
  Insert(1);
  Serve();
  EXPECT_THAT(Served(request), ElementsAre(false, false, true));
  EXPECT_EQ(server_->statistics().batches, 1u);
}

TEST_F(BatchServerTest, SamplesNothingThatNobodyReceives) {
  MakeServer();
  Insert(1);
  learner_->Ask(4);
  learner_.reset();
  Serve();
  EXPECT_EQ(samples_, 0);
  EXPECT_EQ(table_->stats().sampled, 0u);
}

TEST_F(BatchServerTest, ABatchThatFindsTheReaderFullLeavesWhenThereIsRoom) {
  MakeServer();
  Insert(1);
  for (int i = 0; i < kReaderHolds + 2; ++i) learner_->Ask(4);
  Serve();
  EXPECT_EQ(server_->statistics().batches, static_cast<uint64_t>(kReaderHolds));
  EXPECT_EQ(samples_, kReaderHolds + 1) << "one is under way, and no more are sampled before it has left";
  learner_->Ask(4, kReaderHolds + 1);  // which is that one: it is not sampled again
  Serve();
  learner_->RepliesTo(1);
  Serve();
  learner_->RepliesTo(1);
  EXPECT_EQ(learner_->batches().size(), static_cast<size_t>(kReaderHolds + 2));
  EXPECT_EQ(samples_, kReaderHolds + 2);
}

TEST_F(BatchServerTest, ANewLearnerIsServedWhenTheOldOneLeftItsBatchesUntaken) {
  MakeServer();
  Insert(1);
  for (int i = 0; i < 2 * kReaderHolds; ++i) learner_->Ask(4);
  Serve();
  auto old = std::exchange(learner_, std::make_unique<PeerLearner>(transport_, 201, 1));
  const uint64_t request = learner_->Ask(4);
  Serve();  // drops what is stuck on its way to the old one
  old.reset();
  Serve();
  EXPECT_THAT(Served(request), ElementsAre(true));
  EXPECT_EQ(samples_, kReaderHolds + 2) << "what waited of the old one is not sampled";
}

TEST_F(BatchServerTest, RefusesWhatItCanNeverServeAndSaysWhy) {
  MakeServer();
  Insert(1);
  const auto replies = Reader<dadrl_idl_BatchReply>::Create(transport_, kBatchReplyTopic).value();
  const auto requests = Writer<dadrl_idl_BatchRequest>::Create(transport_, kBatchRequestTopic).value();
  dadrl_idl_BatchRequest good{};
  good.learner = 300;
  good.protocol = kProtocolVersion;
  good.trajectories = 4;
  good.steps = 1;
  good.schema = SchemaHash(kTestSpec);
  const auto refusal = [&](dadrl_idl_BatchRequest request) {
    static uint64_t number = 0;
    request.request = ++number;
    EXPECT_TRUE(requests->Write(request));
    Serve();
    std::string reason;
    replies->Take(10, [&](const dadrl_idl_BatchReply& reply) { reason = reply.refusal; });
    return reason;
  };
  dadrl_idl_BatchRequest request = good;
  request.protocol = kProtocolVersion + 1;
  EXPECT_THAT(refusal(request), HasSubstr("version"));
  request = good;
  request.schema = 1;
  EXPECT_THAT(refusal(request), HasSubstr("schema 0x1"));
  request = good;
  request.trajectories = 1 << 30;
  EXPECT_THAT(refusal(request), HasSubstr("1073741824"));
  EXPECT_EQ(server_->statistics().refused_requests, 3u);
  EXPECT_EQ(refusal(good), "");
  request = good;
  request.learner = 299;
  EXPECT_THAT(refusal(request), HasSubstr("learner 300 of this run has taken over"));
}

TEST_F(BatchServerTest, ABatchWithPayloadsThatCannotBeReadIsNotSent) {
  MakeServer();
  // What stands before the payloads is in the file's first page, most of them are behind it.
  const auto chunk = Build({.identity = {1, 100, 1}, .frames = kMaxChunkFrames, .end = kTerminated});
  ASSERT_GT(chunk.size(), 4096u);
  ASSERT_EQ(table_->Insert(chunk).value(), ReplayTable::Insertion::kStored);
  std::filesystem::resize_file(folder_.path() / SegmentLog::NameOf(1), 4096);
  learner_->Ask(64);
  Serve();
  EXPECT_TRUE(learner_->RepliesTo(1).empty() || learner_->RepliesTo(1).back().bytes.empty());
  EXPECT_THAT(learner_->batches(), testing::IsEmpty());
  EXPECT_EQ(table_->stats().damaged_frames, uint64_t{kMaxChunkFrames});
}

TEST_F(BatchServerTest, TakesPrioritiesOfTheLearnerThatItServes) {
  MakeServer();
  Insert(1);
  const auto priorities = Writer<dadrl_idl_PriorityUpdate>::Create(transport_, kPriorityTopic).value();
  uint64_t key = 1;
  float priority = std::numeric_limits<float>::quiet_NaN();
  dadrl_idl_PriorityUpdate update{};
  update.keys = {1, 1, &key, false};
  update.priorities = {1, 1, &priority, false};
  learner_->Ask(4);
  Serve();
  update.learner = 199;
  ASSERT_TRUE(priorities->Write(update));
  Serve();
  EXPECT_EQ(table_->stats().refused_priorities, 0u) << "of a learner that was replaced: not looked at";
  update.learner = 200;
  ASSERT_TRUE(priorities->Write(update));
  Serve();
  EXPECT_EQ(table_->stats().refused_priorities, 1u);
}

}  // namespace
}  // namespace dadrl
