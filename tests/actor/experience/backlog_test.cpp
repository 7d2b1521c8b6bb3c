#include "actor/experience/backlog.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

class BacklogTest : public ::testing::Test {
 protected:
  void Add(int count) {
    for (int i = 0; i < count; ++i) {
      backlog_.Add({.sequence = backlog_.last_sequence() + 1, .bytes = std::vector<std::byte>(10)});
    }
  }
  // Sends whatever may be sent; returns the sequences.
  std::vector<uint64_t> SendAll() {
    std::vector<uint64_t> sent;
    while (const Backlog::Chunk* chunk = backlog_.Next(clock_.Now())) {
      sent.push_back(chunk->sequence);
      backlog_.OnSent(clock_.Now());
    }
    return sent;
  }
  Backlog::AckEffect Acknowledge(uint64_t stored, uint64_t granted) {
    return backlog_.OnAcknowledgement(stored, granted, clock_.Now());
  }

  using Sequences = std::vector<uint64_t>;
  ManualClock clock_;
  Backlog backlog_;
};

TEST_F(BacklogTest, IntroducesItselfWithOneChunkAndThenKeepsToTheGrant) {
  Add(10);
  EXPECT_EQ(SendAll(), Sequences({1}));
  Acknowledge(1, 4);
  EXPECT_EQ(SendAll(), Sequences({2, 3, 4}));
  Acknowledge(2, 4);
  EXPECT_EQ(SendAll(), Sequences());
  Acknowledge(4, 20);
  EXPECT_EQ(SendAll(), Sequences({5, 6, 7, 8, 9, 10}));
}

TEST_F(BacklogTest, NoGrantIsWithoutBound) {
  Add(5000);
  Acknowledge(0, UINT64_MAX);
  EXPECT_EQ(SendAll().size(), Backlog::kMaxGrant);
}

TEST_F(BacklogTest, ASlowDiskMakesAcknowledgementsRareNotLost) {
  Add(100);
  Acknowledge(0, 100);
  SendAll();
  Duration took = Backlog::kFirstResend * 9 / 10;
  for (uint64_t stored = 1; stored <= 4; ++stored, took = took * 3 / 2) {
    clock_.Advance(took);
    EXPECT_EQ(SendAll(), Sequences()) << "after " << ToSeconds(took) << " s";
    Acknowledge(stored, 100);
  }
}

TEST_F(BacklogTest, ForgetsOnlyWhatIsAcknowledged) {
  Add(5);
  Acknowledge(0, 5);
  SendAll();
  EXPECT_EQ(backlog_.bytes(), 50);
  Acknowledge(3, 5);
  EXPECT_EQ(backlog_.bytes(), 20);
  EXPECT_EQ(backlog_.acknowledged(), 3);
}

TEST_F(BacklogTest, SendsTheUnacknowledgedAgainToANewPeer) {
  Add(5);
  Acknowledge(0, 5);
  SendAll();
  Acknowledge(2, 5);
  backlog_.OnNewPeer(clock_.Now());
  EXPECT_EQ(SendAll(), Sequences({3})) << "until the new replay speaks, one chunk introduces us";
  Acknowledge(2, 4);
  EXPECT_EQ(SendAll(), Sequences({4}));
  Acknowledge(2, 9);
  EXPECT_EQ(SendAll(), Sequences({5}));
  EXPECT_EQ(backlog_.resent_chunks(), 3);
}

TEST_F(BacklogTest, SendsAgainWhenNothingIsAcknowledgedMoreAndMoreSlowly) {
  Add(2);
  Acknowledge(0, 5);
  SendAll();
  for (const int wait_s : {1, 2, 4, 8, 8}) {
    clock_.Advance(std::chrono::seconds(wait_s) - std::chrono::milliseconds(1));
    EXPECT_EQ(SendAll(), Sequences()) << wait_s;
    clock_.Advance(std::chrono::milliseconds(1));
    EXPECT_EQ(SendAll(), Sequences({1, 2})) << wait_s;
  }
  Acknowledge(1, 5);
  clock_.Advance(Backlog::kFirstResend);
  EXPECT_EQ(SendAll(), Sequences({2})) << "progress makes it quick again";
}

TEST_F(BacklogTest, RepeatedAcknowledgementsWithoutProgressDoNotPostponeTheResend) {
  Add(2);
  Acknowledge(0, 5);
  SendAll();
  for (int i = 0; i < 4; ++i) {
    clock_.Advance(std::chrono::milliseconds(250));
    Acknowledge(0, 5);
  }
  EXPECT_EQ(SendAll(), Sequences({1, 2}));
}

TEST_F(BacklogTest, AnIdleTimeIsNoStall) {
  Add(1);
  Acknowledge(0, 9);
  SendAll();
  Acknowledge(1, 9);
  clock_.Advance(std::chrono::hours(1));
  Add(1);
  EXPECT_EQ(SendAll(), Sequences({2}));
  EXPECT_EQ(SendAll(), Sequences());
}

TEST_F(BacklogTest, IgnoresAcknowledgementsOfWhatWasNeverMade) {
  Add(2);
  EXPECT_EQ(Acknowledge(3, 100), Backlog::AckEffect::kInvalid);
  EXPECT_EQ(backlog_.acknowledged(), 0);
  EXPECT_EQ(backlog_.granted(), 0);
}

TEST_F(BacklogTest, TellsAReplayThatHasForgottenWhereItIs) {
  Add(9);
  Acknowledge(0, 9);
  SendAll();
  Acknowledge(8, 9);
  EXPECT_EQ(Acknowledge(2, 5), Backlog::AckEffect::kForgotten);
  EXPECT_EQ(backlog_.acknowledged(), 8);
  EXPECT_EQ(backlog_.granted(), 8) << "what was taken was granted";
  backlog_.OnNewPeer(clock_.Now());
  EXPECT_EQ(Acknowledge(2, 5), Backlog::AckEffect::kForgotten);
  Add(3);
  EXPECT_EQ(backlog_.oldest_kept(), 9);
  EXPECT_EQ(SendAll(), Sequences({9})) << "its grant says nothing about what it does not know";
  Acknowledge(9, 12);  // it has skipped what cannot come
  EXPECT_EQ(SendAll(), Sequences({10, 11, 12}));
}

TEST_F(BacklogTest, AnAcknowledgementFromBeforeTheCrashMovesThePointerForward) {
  Add(4);
  Acknowledge(0, 9);
  SendAll();
  backlog_.OnNewPeer(clock_.Now());
  Acknowledge(3, 9);  // the restarted replay found these in its log
  EXPECT_EQ(SendAll(), Sequences({4}));
}

}  // namespace
}  // namespace dadrl
