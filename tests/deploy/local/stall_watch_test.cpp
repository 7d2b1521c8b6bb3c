#include "deploy/local/stall_watch.h"

#include <gmock/gmock.h>

namespace dadrl {
namespace {

using namespace std::chrono_literals;

class StallWatchTest : public testing::Test {
 protected:
  // The fault after `duration` in which nothing moves.
  std::string Still(Duration duration) {
    clock_.Advance(duration);
    return watch_.Look(clock_.Now(), updates_, frames_);
  }
  std::string Train(uint64_t by) {
    updates_ += by;
    return Still(1s);
  }
  std::string Store() {
    ++frames_;
    return Still(1s);
  }

  ManualClock clock_;
  uint64_t updates_ = 0;
  uint64_t frames_ = 0;
  StallWatch watch_{clock_.Now()};
};

TEST_F(StallWatchTest, EitherSideMayWaitForTheOther) {
  for (int i = 0; i < 100; ++i) EXPECT_EQ(Store(), "");  // before training begins
  for (int i = 0; i < 100; ++i) EXPECT_EQ(Train(1), "");
  for (int i = 0; i < 100; ++i) EXPECT_EQ(Store(), "");
}

TEST_F(StallWatchTest, NeitherMovesIsAFaultWithTheTimeItHadLasted) {
  Train(1);
  EXPECT_EQ(Still(10s), "");
  EXPECT_EQ(Still(1s), "neither an update nor a stored frame");
  EXPECT_EQ(watch_.TakeOverdue(), 11s);
  EXPECT_NE(Still(1s), "");
  EXPECT_EQ(watch_.TakeOverdue(), 0s);
  EXPECT_EQ(Store(), "");
}

TEST_F(StallWatchTest, TheFirstProcessesMayTakeLonger) {
  EXPECT_EQ(Still(59s), "");
  EXPECT_NE(Still(2s), "");
}

TEST_F(StallWatchTest, RepeatedUpdatesAreLostOnesUntilTheyAreMadeUpFor) {
  Train(100);
  updates_ = 0;  // a new learner, which has not begun
  EXPECT_EQ(Still(1s), "");
  EXPECT_EQ(Train(40), "the learner repeats updates that were lost");
  EXPECT_NE(Train(59), "");
  EXPECT_EQ(Train(2), "");
}

TEST_F(StallWatchTest, APauseIsNoTime) {
  Train(1);
  clock_.Advance(1h);
  watch_.AddPause(1h);
  EXPECT_EQ(Still(9s), "");
}

}  // namespace
}  // namespace dadrl
