#include "replay/service/ingest.h"

#include <gmock/gmock.h>

#include "tests/replay/service/memory_shard.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;

class IngestTest : public MemoryShard {
 protected:
  void MakeIngest(Segment::Force force = SyncFile) {
    OpenTable(std::move(force));
    ingest_ = Ingest::Create(transport_, config_, 0, *table_, clock_, [this] { ++inserts_; }).value();
    actor_ = std::make_unique<PeerActor>(transport_, 1, 100);
  }
  void Add(int chunks) {
    for (int i = 0; i < chunks; ++i) actor_->Add({.episode = actor_->produced() + 1, .end = kTerminated});
  }
  // Actor and ingest take turns.
  void Pass(int turns = 6) {
    for (; turns > 0; --turns) {
      actor_->Pump();
      ingest_->Step();
    }
    actor_->Pump();
  }

  std::unique_ptr<Ingest> ingest_;
  std::unique_ptr<PeerActor> actor_;
  int inserts_ = 0;
};

TEST_F(IngestTest, StoresAcknowledgesAndGrantsMore) {
  MakeIngest();
  Add(5);
  Pass();
  EXPECT_EQ(actor_->stored(), 5u);
  EXPECT_EQ(actor_->granted(), 5u + 64u);
  EXPECT_EQ(table_->stats().inserted_frames, 20u);
  EXPECT_GT(inserts_, 0);
}

TEST_F(IngestTest, ManyChunksAreAcknowledgedTogetherAndSoonEnough) {
  MakeIngest();
  Add(1);
  Pass();
  const auto acknowledgements =
      Reader<dadrl_idl_Acknowledgement>::Create(transport_, AcknowledgementTopic(1)).value();
  const auto heard = [&] { return acknowledgements->Take(10, [](const dadrl_idl_Acknowledgement&) {}) > 0; };
  ASSERT_TRUE(heard()) << "the last word, for who comes late";
  Add(3);
  actor_->Pump();
  ingest_->Step();
  ASSERT_TRUE(heard());
  Add(3);
  actor_->Pump();
  ingest_->Step();
  EXPECT_FALSE(heard()) << "not twice within kMinInterval";
  ingest_->Step();  // waits for it to pass
  ingest_->Step();
  EXPECT_TRUE(heard());
}

TEST_F(IngestTest, WithholdsItsGrantWhileTheLearnerIsBehind) {
  config_.replay.min_samples_per_insert = 0.5;
  config_.replay.samples_per_insert_band = 1.0;
  MakeIngest();
  Add(200);
  Pass(50);
  const uint64_t held_at = actor_->stored();
  EXPECT_LT(held_at, 20u);
  EXPECT_EQ(actor_->granted(), held_at);
  for (int i = 0; i < 10; ++i) ASSERT_TRUE(table_->Sample({4}, 0));
  ingest_->Wake();
  Pass(50);
  EXPECT_GT(actor_->stored(), held_at);
}

TEST_F(IngestTest, RefusesByNameWhatIsNoChunkAndTakesTheNext) {
  MakeIngest();
  actor_->AddRaw(std::vector<std::byte>(500, std::byte{0x5a}));
  Add(1);
  Pass();
  EXPECT_EQ(actor_->stored(), 2u) << "the refused one counts as done";
  EXPECT_EQ(actor_->refused(), 1u);
  EXPECT_EQ(actor_->refusal().first, ChunkFault::kGarbage);
  EXPECT_EQ(table_->stats().inserted_frames, 4u);
}

TEST_F(IngestTest, UnderSyncAlwaysNothingIsAcknowledgedBeforeItIsOnTheDevice) {
  config_.replay.sync = SyncMode::kAlways;
  bool broken = true;
  int forced = 0;
  MakeIngest([&](const FileDescriptor&, const std::filesystem::path& path) -> Status {
    ++forced;
    if (broken) return Fail(ErrorCode::kExhausted, "{}: no space left on device", path.string());
    return {};
  });
  Add(3);
  Pass(2);
  EXPECT_EQ(actor_->stored(), 0u);
  EXPECT_GT(forced, 0);
  broken = false;
  clock_.Advance(Ingest::kRetryInterval);
  Pass(2);
  EXPECT_GT(actor_->stored(), 0u);
}

}  // namespace
}  // namespace dadrl
