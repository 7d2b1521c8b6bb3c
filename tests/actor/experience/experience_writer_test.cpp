// Over memory, on a clock of the test's: writer and replay take turns.
#include "actor/experience/experience_writer.h"

#include <gmock/gmock.h>

#include <set>

#include "common/port/memory_transport.h"
#include "common/step/driving_shape.h"
#include "tests/actor/experience/replay_peer.h"

namespace dadrl {
namespace {

constexpr uint32_t kActor = 3;
constexpr uint64_t kIncarnation = 1234567890123;

class ExperienceWriterTest : public ::testing::Test {
 protected:
  ExperienceWriterTest() : observation_(DrivingShape::From(config_.observation)) {
    config_.actor.chunk_frames = 4;
    clock_.Advance(std::chrono::hours(1));
  }
  void MakeWriter() {
    writer_ = ExperienceWriter::Create(transport_, config_, kActor, kIncarnation, clock_).value();
  }
  void StartReplay(uint64_t window) { replay_ = std::make_unique<ReplayPeer>(transport_, disk_, window); }
  void Step() {
    writer_->Step();
    if (replay_) replay_->Step();
  }
  // Steps until `condition` holds, for half a minute of the clock.
  bool Eventually(const std::function<bool()>& condition) {
    for (const TimePoint end = clock_.Now() + std::chrono::seconds(30); clock_.Now() < end; Step()) {
      if (condition()) return true;
    }
    return condition();
  }

  // An episode of `chunks` whole chunks. Rewards count the transitions of the test.
  void DriveEpisode(int chunks) {
    writer_->BeginEpisode(++episode_);
    for (int i = 0; i < chunks * config_.actor.chunk_frames; ++i) {
      const bool last = i + 1 == chunks * config_.actor.chunk_frames;
      writer_->AddTransition(observation_, Action{0.5f, -0.5f}, reward_++, last ? kTerminated : 0, 1);
    }
    writer_->EndEpisode();
  }
  void DriveUntilBlocked() {
    for (; !writer_->blocked(); Step()) DriveEpisode(1);
  }
  // Every transition of the test is on the disk, once, in order.
  void ExpectEverythingStored() {
    ASSERT_TRUE(Eventually([&] { return writer_->Flush(Duration::zero()); }));
    float expected = 0.0f;
    uint64_t sequence = 0;
    for (const ReplayDisk::Stored& chunk : disk_.Copy()) {
      EXPECT_EQ(chunk.sequence, ++sequence);
      for (const float reward : chunk.rewards) EXPECT_EQ(reward, expected++);
    }
    EXPECT_EQ(expected, reward_);
    EXPECT_EQ(sequence, writer_->statistics().chunks);
    EXPECT_EQ(writer_->statistics().backlog_bytes, 0);
  }

  Config config_;
  Observation observation_;
  ReplayDisk disk_;
  ManualClock clock_;
  const MemoryTransport transport_{clock_};
  std::unique_ptr<ExperienceWriter> writer_;
  std::unique_ptr<ReplayPeer> replay_;
  uint64_t episode_ = 0;
  float reward_ = 0.0f;
};

TEST_F(ExperienceWriterTest, CutsEpisodesIntoChunks) {
  MakeWriter();
  StartReplay(100);
  writer_->BeginEpisode(7);
  for (int i = 0; i < 6; ++i) {
    writer_->AddTransition(observation_, Action{}, reward_++, i == 5 ? kTruncated : 0, 1);
  }
  writer_->AddFinal(observation_);
  writer_->EndEpisode();
  writer_->BeginEpisode(8);
  writer_->AddTransition(observation_, Action{}, reward_++, 0, 1);
  ASSERT_TRUE(Eventually([&] { return writer_->Flush(Duration::zero()); }));
  const auto chunks = disk_.Copy();
  ASSERT_EQ(chunks.size(), 3);
  EXPECT_EQ(std::tie(chunks[0].episode, chunks[0].first_frame), std::make_tuple(7u, 0u));
  EXPECT_EQ(chunks[0].rewards.size(), 4);
  EXPECT_EQ(std::tie(chunks[1].episode, chunks[1].first_frame), std::make_tuple(7u, 4u));
  EXPECT_EQ(chunks[1].rewards.size(), 3) << "two transitions and the final observation";
  EXPECT_EQ(std::tie(chunks[2].episode, chunks[2].first_frame), std::make_tuple(8u, 0u));
}

TEST_F(ExperienceWriterTest, StartsBeforeTheReplayAndLosesNothing) {
  MakeWriter();
  DriveEpisode(20);
  EXPECT_FALSE(writer_->statistics().replay_present);
  StartReplay(5);
  ExpectEverythingStored();
}

TEST_F(ExperienceWriterTest, LosesNothingWhenTheReplayRestarts) {
  MakeWriter();
  for (int round = 0; round < 3; ++round) {
    StartReplay(8);
    const uint64_t before = disk_.stored();
    DriveEpisode(10);
    ASSERT_TRUE(Eventually([&] { return disk_.stored() > before + 1; }));
    replay_ = nullptr;
    DriveEpisode(10);
  }
  StartReplay(8);
  ExpectEverythingStored();
}

TEST_F(ExperienceWriterTest, HoldsBackWhatIsNotGranted) {
  MakeWriter();
  StartReplay(0);
  DriveEpisode(1);
  ASSERT_TRUE(Eventually([&] { return writer_->statistics().granted == 1; }));
  DriveUntilBlocked();
  EXPECT_EQ(writer_->statistics().chunks, 1 + ExperienceWriter::kAhead + 1);
  EXPECT_FALSE(writer_->Flush(std::chrono::milliseconds(200)));
  EXPECT_EQ(replay_->highest_seen(), 1);
  replay_->set_window(3);
  EXPECT_TRUE(Eventually([&] { return !writer_->blocked(); }));
  DriveEpisode(3);
  ExpectEverythingStored();
}

TEST_F(ExperienceWriterTest, SendsAgainWhatWasLostOnTheWay) {
  MakeWriter();
  StartReplay(50);
  DriveEpisode(2);
  ASSERT_TRUE(Eventually([&] { return disk_.stored() == 2; }));
  replay_->LoseNext(2);
  DriveEpisode(10);
  ExpectEverythingStored();
  EXPECT_GE(writer_->statistics().resent, 2);
}

TEST_F(ExperienceWriterTest, ALateAcknowledgementCostsDuplicatesNotData) {
  MakeWriter();
  StartReplay(50);
  DriveEpisode(1);
  ASSERT_TRUE(Eventually([&] { return writer_->statistics().granted == 51; }));
  replay_->set_acknowledging(false);
  DriveEpisode(5);
  ASSERT_TRUE(Eventually([&] { return writer_->statistics().resent > 0; }));
  EXPECT_EQ(writer_->statistics().acknowledged, 1);
  replay_->set_acknowledging(true);
  ExpectEverythingStored();
}

TEST_F(ExperienceWriterTest, BoundsTheBacklogWhileTheReplayIsAway) {
  config_.actor.max_unacknowledged_bytes = 1 << 16;
  MakeWriter();
  EXPECT_FALSE(writer_->blocked());
  DriveUntilBlocked();
  const int64_t bytes = writer_->statistics().backlog_bytes;
  EXPECT_GE(bytes, 1 << 16);
  EXPECT_LT(bytes, (1 << 16) + (1 << 15)) << "at most one chunk beyond the bound";
  EXPECT_FALSE(writer_->Flush(std::chrono::milliseconds(1)));
  StartReplay(5);
  EXPECT_TRUE(Eventually([&] { return !writer_->blocked(); }));
  ExpectEverythingStored();
}

TEST_F(ExperienceWriterTest, DropsAndCountsWhatIsRefusedForGoodAndGoesOn) {
  MakeWriter();
  StartReplay(0);
  replay_->set_acknowledging(false);
  DriveEpisode(3);
  ASSERT_TRUE(Eventually([&] { return replay_->highest_seen() == 1; }));
  dadrl_idl_Acknowledgement ack{};
  ack.actor = kActor;
  ack.incarnation = kIncarnation;
  ack.stored_sequence = ack.refused_sequence = ack.refused = 1;
  ack.granted_sequence = 2;
  ack.refusal = static_cast<uint32_t>(ChunkFault::kContents);
  replay_->SendAcknowledgement(ack);
  ASSERT_TRUE(Eventually([&] { return writer_->statistics().acknowledged == 1; }));
  ASSERT_TRUE(Eventually([&] { return replay_->highest_seen() == 2; })) << "the next one comes";
  EXPECT_EQ(writer_->statistics().refused, 1);
  EXPECT_TRUE(writer_->status());
  // Two more, of which the first word was lost; then a replay that counts anew.
  ack.stored_sequence = ack.refused_sequence = ack.refused = 3;
  replay_->SendAcknowledgement(ack);
  ASSERT_TRUE(Eventually([&] { return writer_->statistics().refused == 3; }));
  ack.refused = 1;
  replay_->SendAcknowledgement(ack);
  EXPECT_TRUE(Eventually([&] { return writer_->statistics().refused == 4; }));
}

TEST_F(ExperienceWriterTest, EndsWhenALaterIncarnationHasItsNumber) {
  MakeWriter();
  StartReplay(0);
  replay_->set_acknowledging(false);
  DriveUntilBlocked();
  dadrl_idl_Acknowledgement ack{};
  ack.actor = kActor;
  ack.incarnation = kIncarnation + 1;
  replay_->SendAcknowledgement(ack);
  ASSERT_TRUE(Eventually([&] { return !writer_->status(); }));
  EXPECT_EQ(writer_->status().error().code, ErrorCode::kExhausted);
  EXPECT_THAT(writer_->status().error().message, testing::HasSubstr("actor number 3"));
  EXPECT_FALSE(writer_->blocked()) << "nobody waits for what never comes";
  EXPECT_FALSE(writer_->Flush(std::chrono::seconds(60)));
}

TEST_F(ExperienceWriterTest, IgnoresAcknowledgementsMeantForOthersOrImpossible) {
  MakeWriter();
  StartReplay(0);
  replay_->set_acknowledging(false);
  DriveEpisode(3);
  ASSERT_TRUE(Eventually([&] { return disk_.stored() == 1; }));
  dadrl_idl_Acknowledgement ack{};
  ack.actor = kActor;
  ack.incarnation = kIncarnation - 1;  // an earlier life of this actor
  ack.stored_sequence = ack.granted_sequence = 2;
  replay_->SendAcknowledgement(ack);
  ack.actor = kActor + 1;
  ack.incarnation = kIncarnation;
  replay_->SendAcknowledgement(ack);
  ack.actor = kActor;
  ack.stored_sequence = ack.granted_sequence = 1000;
  replay_->SendAcknowledgement(ack);
  ASSERT_TRUE(Eventually([&] { return writer_->statistics().invalid_acknowledgements == 1; }));
  EXPECT_EQ(writer_->statistics().acknowledged, 0);
  replay_->set_window(10);
  replay_->set_acknowledging(true);
  ExpectEverythingStored();
}

}  // namespace
}  // namespace dadrl
