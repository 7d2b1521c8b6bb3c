#include "deploy/local/lost_time.h"

#include <gmock/gmock.h>

#include <vector>

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using Faults = std::vector<std::string>;

class LostTimeTest : public testing::Test {
 protected:
  // `faults` last for `duration`.
  void Pass(Duration duration, const Faults& faults) {
    clock_.Advance(duration);
    lost_.Observe(clock_.Now(), faults);
  }
  void SetUp() override { lost_.Skip(clock_.Now()); }

  ManualClock clock_;
  LostTime lost_;
};

TEST_F(LostTimeTest, SumsUpEachFaultWhileItLasts) {
  Pass(10s, {});
  Pass(3s, {"replay-0 hangs"});
  Pass(4s, {"replay-0 hangs"});
  Pass(100s, {});
  Pass(1s, {"learner starts again"});
  EXPECT_EQ(lost_.total(), 8s);
  EXPECT_EQ(lost_.Sentence(118s), "8 of 118 s lost to faults: 7 s replay-0 hangs, 1 s learner starts again");
}

TEST_F(LostTimeTest, TwoFaultsAtOnceTakeNoMoreTimeThanThereIs) {
  Pass(10s, {"replay-0 hangs", "learner hangs"});
  EXPECT_EQ(lost_.total(), 10s);
}

TEST_F(LostTimeTest, TimeThatIsSkippedBelongsToNothing) {
  clock_.Advance(1h);
  lost_.Skip(clock_.Now());
  Pass(1s, {"replay-0 hangs"});
  EXPECT_EQ(lost_.total(), 1s);
}

TEST_F(LostTimeTest, HalfOfTheTimeHoldsUpARun) {
  Pass(60s, {"the replay cannot store"});
  EXPECT_FALSE(lost_.HeldUp(120s));
  EXPECT_TRUE(lost_.HeldUp(119s));
}

TEST_F(LostTimeTest, ARestartIsNoFaultOfAShortRun) {
  Pass(15s, {"learner starts again"});
  EXPECT_FALSE(lost_.HeldUp(20s));
  lost_.Add("learner repeats lost updates", 6s);
  EXPECT_TRUE(lost_.HeldUp(26s));
}

TEST_F(LostTimeTest, NothingLostIsNotWorthASentence) {
  Pass(60s, {});
  EXPECT_EQ(lost_.Sentence(60s), "");
}

}  // namespace
}  // namespace dadrl
