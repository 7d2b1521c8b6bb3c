#include "actor/task/reward.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

EgoLocation At(double remaining, double limit = 10.0) {
  EgoLocation location;
  location.remaining = remaining;
  location.speed_limit = limit;
  location.lane_index = 0;
  return location;
}

class RewardTest : public testing::Test {
 protected:
  RewardTest() { reward_.Begin(1.0); }
  RewardFunction reward_{RewardConfig{}};
};

TEST_F(RewardTest, CrashOffRoadAndGoalAreMinusOneMinusOneAndThree) {
  EXPECT_DOUBLE_EQ(reward_.Step(0, At(1), Events{.collision = true}).crash, -1.0);
  EXPECT_DOUBLE_EQ(reward_.Step(0, At(1), Events{.off_road = true}).off_road, -1.0);
  EXPECT_DOUBLE_EQ(reward_.Step(0, At(1), Events{.goal = true}).goal, 3.0);
}

TEST_F(RewardTest, OfSimultaneousEndsOnlyTheFirstCounts) {
  const RewardTerms all = reward_.Step(0, At(1), Events{.collision = true, .off_road = true, .goal = true});
  EXPECT_DOUBLE_EQ(all.Sum(), -1.0);
  const RewardTerms two = reward_.Step(0, At(1), Events{.off_road = true, .goal = true});
  EXPECT_DOUBLE_EQ(two.Sum(), -1.0);
}

TEST_F(RewardTest, ProgressAddsUpToTwiceTheFractionDriven) {
  EXPECT_NEAR(reward_.Step(0, At(0.9), {}).progress, 0.2, 1e-12);
  EXPECT_NEAR(reward_.Step(0, At(0.95), {}).progress, -0.1, 1e-12);  // driven back
  EXPECT_NEAR(reward_.Step(0, At(0.0), {}).progress, 1.9, 1e-12);
}

TEST_F(RewardTest, SpeedPaysUpToTheLimitAndCostsAboveIt) {
  EXPECT_NEAR(reward_.Step(5.0, At(1), {}).speed, 0.005, 1e-12);
  EXPECT_NEAR(reward_.Step(10.0, At(1), {}).speed, 0.01, 1e-12);
  EXPECT_NEAR(reward_.Step(12.0, At(1), {}).speed, -0.002, 1e-12);
  EXPECT_EQ(reward_.Step(12.0, At(1, 0.0), {}).speed, 0.0);  // off the lanes
}

TEST_F(RewardTest, AstrayThereIsNoSpeedBonusButTheExcessStillCosts) {
  EXPECT_EQ(reward_.Step(5.0, At(1), Events{.off_route = true}).speed, 0.0);
  EXPECT_EQ(reward_.Step(5.0, At(1), Events{.wrong_way = true}).speed, 0.0);
  EXPECT_NEAR(reward_.Step(12.0, At(1), Events{.wrong_way = true}).speed, -0.002, 1e-12);
}

TEST_F(RewardTest, OffRouteAndWrongWayCostAHundredthEachStep) {
  const RewardTerms terms = reward_.Step(0, At(1), Events{.off_route = true, .wrong_way = true});
  EXPECT_DOUBLE_EQ(terms.off_route, -0.01);
  EXPECT_DOUBLE_EQ(terms.wrong_way, -0.01);
  EXPECT_DOUBLE_EQ(terms.Sum(), -0.02);
}

TEST_F(RewardTest, SlowCostsAFifthEveryTenConsecutiveSeconds) {
  double total = 0.0;
  for (int step = 1; step <= 250; ++step) {
    const double slow = reward_.Step(0.9, At(1), {}).slow;
    EXPECT_DOUBLE_EQ(slow, step == 100 || step == 200 ? -0.2 : 0.0) << step;
    total += slow;
  }
  EXPECT_DOUBLE_EQ(total, -0.4);
}

TEST_F(RewardTest, MovingOnStartsTheTenSecondsAnew) {
  for (int step = 0; step < 99; ++step) EXPECT_EQ(reward_.Step(0.0, At(1), {}).slow, 0.0);
  reward_.Step(1.0, At(1), {});  // a tenth of the limit is not below it
  for (int step = 0; step < 99; ++step) EXPECT_EQ(reward_.Step(0.0, At(1), {}).slow, 0.0);
  EXPECT_DOUBLE_EQ(reward_.Step(0.0, At(1), {}).slow, -0.2);
  reward_.Begin(1.0);
  for (int step = 0; step < 99; ++step) EXPECT_EQ(reward_.Step(0.0, At(1), {}).slow, 0.0);
}

TEST(RewardFunction, EveryWeightIsConfiguration) {
  RewardConfig weights;
  weights.crash = -7;
  weights.off_road = -6;
  weights.goal = 5;
  weights.progress = 4;
  weights.speed = 3;
  weights.off_route = -2;
  weights.wrong_way = -1;
  weights.slow = -8;
  RewardFunction reward(weights);
  reward.Begin(1.0);
  EXPECT_DOUBLE_EQ(reward.Step(0, At(1), Events{.collision = true}).Sum(), -7);
  EXPECT_DOUBLE_EQ(reward.Step(0, At(1), Events{.off_road = true}).Sum(), -6);
  EXPECT_DOUBLE_EQ(reward.Step(0, At(1), Events{.goal = true}).Sum(), 5);
  EXPECT_DOUBLE_EQ(reward.Step(0, At(0.5), {}).Sum(), 2);
  EXPECT_DOUBLE_EQ(reward.Step(10, At(0.5), {}).Sum(), 3);
  EXPECT_DOUBLE_EQ(reward.Step(0, At(0.5), Events{.off_route = true, .wrong_way = true}).Sum(), -3);
  for (int i = 0; i < 98; ++i) reward.Step(0, At(0.5), {});
  EXPECT_DOUBLE_EQ(reward.Step(0, At(0.5), {}).Sum(), -8);
}

}  // namespace
}  // namespace dadrl
