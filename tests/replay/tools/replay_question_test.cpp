// Over memory, on a clock of the test's: waiting is the passing of its time.
#include "replay/tools/replay_question.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/port/memory_transport.h"

namespace dadrl {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

class ReplayQuestion : public testing::Test {
 protected:
  ReplayQuestion() { config_.replay.shards = 2; }
  auto Ask() {
    return AskShards(transport_, config_, {}, clock_, [this](const std::string& text) {
      said_.push_back(text);
      after_s_ = ToSeconds(clock_.Now() - began_);
    });
  }
  auto Listen() { return Reader<dadrl_idl_ReplayCommand>::Create(transport_, kReplayCommandTopic).value(); }
  double WaitedSeconds() const { return ToSeconds(clock_.Now() - began_); }

  ManualClock clock_;
  const TimePoint began_ = clock_.Now();
  const MemoryTransport transport_{clock_};
  Config config_;
  std::vector<std::string> said_;
  double after_s_ = 0.0;
};

TEST_F(ReplayQuestion, WhomItWaitsForIsSaidWithinSecondsAndAnAbsentShardIsNotWaitedForLong) {
  const auto only = Listen();
  const auto asked = Ask();
  ASSERT_FALSE(asked);
  EXPECT_EQ(asked.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(asked.error().message, AllOf(HasSubstr("replay shard 0, 1: 1 of 2 shards listen at 127.0.0.1"),
                                           HasSubstr("dadrl monitor")));
  EXPECT_THAT(said_, ElementsAre(HasSubstr("waiting for replay shard 0, 1")));
  EXPECT_NEAR(after_s_, 3.0, 0.5);
  EXPECT_NEAR(WaitedSeconds(), 10.0 * config_.cluster.liveliness_s + config_.cluster.lease_s, 0.5);
}

TEST_F(ReplayQuestion, AShardThatListensHasAMinute) {
  const auto first = Listen();
  const auto second = Listen();
  const auto asked = Ask();
  ASSERT_FALSE(asked);
  EXPECT_THAT(asked.error().message, HasSubstr("listens and has not answered"));
  EXPECT_EQ(said_.size(), 1u);
  EXPECT_NEAR(WaitedSeconds(), 60.0, 0.5);
}

}  // namespace
}  // namespace dadrl
