#include "deploy/local/run_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using Verdict = RunPresence::Verdict;

class RunPresenceTest : public testing::Test {
 protected:
  TimePoint now_{100s};
  RunPresence presence_{"10.0.0.1:12000", now_};
};

TEST_F(RunPresenceTest, ARunThatSaidThatItEndsAndDoesNotComeBackHasEnded) {
  EXPECT_EQ(presence_.Update(true, false, now_), Verdict::kThere);
  EXPECT_EQ(presence_.Update(true, true, now_), Verdict::kAway);
  now_ += RunPresence::kReturn - 1ms;
  EXPECT_EQ(presence_.Update(false, true, now_), Verdict::kAway);
  now_ += 1ms;
  EXPECT_EQ(presence_.Update(false, true, now_), Verdict::kEnded);
  EXPECT_EQ(presence_.TakeNotice(), std::nullopt) << "whoever ends it says so";
}

TEST_F(RunPresenceTest, AReplayThatWasAskedToEndAndIsStartedAgainIsNoEnd) {
  presence_.Update(true, true, now_);
  now_ += 2s;
  EXPECT_EQ(presence_.Update(true, false, now_), Verdict::kThere);
  now_ += 60s;
  EXPECT_EQ(presence_.Update(true, false, now_), Verdict::kThere);
}

TEST_F(RunPresenceTest, AReplayThatWasKilledIsWaitedForAndThatIsSaidEveryNowAndThen) {
  presence_.Update(false, false, now_);
  EXPECT_EQ(presence_.TakeNotice(), std::nullopt) << "it may be back in a moment";
  now_ += RunPresence::kFirstNotice;
  EXPECT_EQ(presence_.Update(false, false, now_), Verdict::kAway);
  EXPECT_THAT(presence_.TakeNotice().value_or(""), HasSubstr("10.0.0.1:12000 has not answered for 15 s"));
  EXPECT_EQ(presence_.TakeNotice(), std::nullopt);
  now_ += RunPresence::kNoticeInterval;
  presence_.Update(false, false, now_);
  EXPECT_NE(presence_.TakeNotice(), std::nullopt);
  EXPECT_EQ(presence_.Update(true, false, now_), Verdict::kThere);
  EXPECT_THAT(presence_.TakeNotice().value_or(""), HasSubstr("is back"));
}

TEST_F(RunPresenceTest, NobodyWaitsForEver) {
  presence_.Update(false, false, now_);
  now_ += RunPresence::kPatience;
  EXPECT_EQ(presence_.Update(false, false, now_), Verdict::kGivenUp);
}

}  // namespace
}  // namespace dadrl
