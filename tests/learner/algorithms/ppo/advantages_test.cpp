#include "learner/algorithms/ppo/advantages.h"

#include <gmock/gmock.h>

#include "tests/learner/algorithms/ppo/rollout.h"

namespace dadrl {
namespace {

using testing::FloatEq;
using testing::Pointwise;

constexpr TrajectoryShape kShape{.count = 3, .steps = 4, .all_observations = true};

// [t][b]; trajectory 1 terminates after two steps, trajectory 2 is truncated after three.
class AdvantagesTest : public testing::Test {
 protected:
  AdvantagesTest() : batch_(AnyRollout(SmallPpo(12, 4), kShape, 1)) {
    batch_.rewards = {1, 1, 0,  //
                      0, 3, 0,  //
                      2, 9, 1,  //
                      0, 9, 9};
  }
  const std::vector<float> values_ = {2, 1, 1,  //
                                      4, 2, 0,  //
                                      0, 7, 2,  //
                                      1, 7, 4,  //
                                      6, 7, 7};
  TrajectoryBatch batch_;
  Advantages result_;
};

// gamma 0.5, lambda 0.5, all on policy. Trajectory 0: errors 1 + 2 - 2 = 1, 0 + 0 - 4 = -4, 2 + 0.5 - 0
// = 2.5, 0 + 3 - 1 = 2; from behind 2, 2.5 + 2 / 4 = 3, -4 + 3 / 4 = -3.25, 1 - 3.25 / 4 = 0.1875. Trajectory
// 1, terminated: errors 1 + 1 - 1 = 1, 3 - 2 = 1; 1, 1.25. Trajectory 2, truncated: errors 0 + 0 - 1 = -1, 0
// + 1 - 0 = 1, 1 + 2 - 2 = 1; 1, 1.25, -0.6875.
TEST_F(AdvantagesTest, MatchAHandWorkedTableOnPolicy) {
  EstimateAdvantages(batch_, values_, std::vector<float>(12, 1.0f), 0.5, 0.5, result_);
  EXPECT_THAT(result_.advantage, Pointwise(FloatEq(), {0.1875f, 1.25f, -0.6875f,  //
                                                       -3.25f, 1.0f, 1.25f,       //
                                                       3.0f, 0.0f, 1.0f,          //
                                                       2.0f, 0.0f, 0.0f}));
  EXPECT_THAT(result_.value_target, Pointwise(FloatEq(), {2.1875f, 2.25f, 0.3125f,  //
                                                          0.75f, 3.0f, 1.25f,       //
                                                          3.0f, 0.0f, 3.0f,         //
                                                          3.0f, 0.0f, 0.0f}));
}

// The same where the policy of now does what was done half as likely at steps 1 and 3 of trajectory 0, and
// twice as likely at step 2, which cuts nothing: 2, 2.5 + 0.5 * 2 / 4 = 2.75, -4 + 2.75 / 4 = -3.3125,
// 1 - 0.5 * 3.3125 / 4 = 0.5859375.
TEST_F(AdvantagesTest, CutTracesWhereThePolicyHasChanged) {
  std::vector<float> ratios(12, 1.0f);
  ratios[3] = 0.5f;
  ratios[6] = 2.0f;
  ratios[9] = 0.5f;
  EstimateAdvantages(batch_, values_, ratios, 0.5, 0.5, result_);
  const auto of_first = [](const std::vector<float>& values) {
    return std::vector<float>{values[0], values[3], values[6], values[9]};
  };
  EXPECT_THAT(of_first(result_.advantage), Pointwise(FloatEq(), {0.5859375f, -3.3125f, 2.75f, 2.0f}));
  EXPECT_THAT(of_first(result_.value_target),
              Pointwise(FloatEq(), {2.5859375f, 4.0f - 0.5f * 3.3125f, 2.75f, 1.0f + 0.5f * 2.0f}));
}

TEST_F(AdvantagesTest, WithLambdaZeroAreTheErrorsOfOneStepAndWithOneThoseOfTheReturn) {
  const std::vector<float> on_policy(12, 1.0f);
  EstimateAdvantages(batch_, values_, on_policy, 0.5, 0.0, result_);
  EXPECT_FLOAT_EQ(result_.advantage[0], 1.0f);
  EXPECT_FLOAT_EQ(result_.advantage[3], -4.0f);
  EstimateAdvantages(batch_, values_, on_policy, 0.5, 1.0, result_);
  EXPECT_FLOAT_EQ(result_.value_target[0], 1.0f + 0.25f * 2.0f + 0.0625f * 6.0f);
  EXPECT_FLOAT_EQ(result_.value_target[1], 1.0f + 0.5f * 3.0f);
}

}  // namespace
}  // namespace dadrl
