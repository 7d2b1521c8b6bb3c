#include "proto/experience_bounds.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

#include "common/step/driving_shape.h"
#include "proto/experience.h"

namespace dadrl {
namespace {

TEST(ExperienceBounds, RewardIsTheSumOfTheLargestTerms) {
  const ExperienceBounds bounds = ExperienceBounds::From(Config{});
  // Goal 3, progress 2, three steps of speed 0.01 x 10 and twice 0.01 astray, slow 0.2.
  EXPECT_NEAR(bounds.reward, 3.0 + 2.0 + 3 * (0.01 * 10 + 0.02) + 0.2, 1e-3);
  EXPECT_TRUE(bounds.AllowsReward(-5.5f));
  EXPECT_FALSE(bounds.AllowsReward(5.7f));
  EXPECT_FALSE(bounds.AllowsReward(1e30f));
  EXPECT_FALSE(bounds.AllowsReward(std::numeric_limits<float>::quiet_NaN()));
}

TEST(ExperienceBounds, FollowTheWeightsWhateverTheirSign) {
  Config config;
  config.task.reward = {.crash = -50,
                        .off_road = 0,
                        .goal = 1,
                        .progress = -7,
                        .speed = -2,
                        .off_route = 1,
                        .wrong_way = -1,
                        .slow = -4};
  config.task.decision_interval = 2;
  config.task.max_speed_mps = 20;
  EXPECT_NEAR(ExperienceBounds::From(config).reward, 50 + 7 + 2 * (2 * 20 + 2) + 4, 1e-2);
}

TEST(ExperienceBounds, OfAnyTaskAllowWhatAnyConfigurationCanGiveAndLittleMore) {
  const ExperienceBounds any = ExperienceBounds::OfAnyTask();
  EXPECT_GT(any.reward, 100 + 100 + 100 + 20 * (100 * 40 + 2 * 100) - 1);
  EXPECT_LT(any.reward, 1e6);
  EXPECT_TRUE(std::isfinite(any.value));
  EXPECT_FALSE(any.AllowsReward(1e30f));
}

TEST(ExperienceBounds, CheckRewardsNamesTheFrameTheRewardAndTheBound) {
  const ExperienceBounds bounds = ExperienceBounds::From(Config{});
  const DrivingShape spec{.vehicles = 1, .history = 1};
  const auto check = [&](float second) {
    ChunkBuilder builder(spec, FloatCoding::kFloat16);
    builder.Begin(/*episode=*/9, /*first_frame=*/64);
    builder.AddTransition(Observation(spec), Action{}, 5.5f, 0, 1);
    builder.AddTransition(Observation(spec), Action{}, second, 0, 1);
    const std::vector<std::byte> bytes = builder.Finish({.actor = 7, .incarnation = 1, .sequence = 1});
    return CheckRewards(ChunkView::Parse(bytes).value(), bounds);
  };
  EXPECT_TRUE(check(-5.5f));
  for (const float reward : {1e30f, 3e38f, -3e38f}) {
    const Status checked = check(reward);
    ASSERT_FALSE(checked);
    EXPECT_EQ(checked.error().code, ErrorCode::kCorrupt);
    EXPECT_EQ(
        checked.error().message,
        fmt::format("actor 7, episode 9, frame 65: reward {:g} is beyond 5.56, the most this task gives",
                    reward));
  }
}

TEST(ExperienceBounds, ValueIsTheRewardForEverDiscounted) {
  Config config;
  config.algorithm.gamma = 0.99;
  const ExperienceBounds bounds = ExperienceBounds::From(config);
  EXPECT_NEAR(bounds.value, 100 * bounds.reward, 1e-3);
  EXPECT_NEAR(bounds.priority, 200 * bounds.reward, 1e-3);
  config.algorithm.gamma = 1.0;
  EXPECT_TRUE(std::isfinite(ExperienceBounds::From(config).value));
}

TEST(ExperienceBounds, PrioritiesAreNeitherNegativeNorNoNumbers) {
  const ExperienceBounds bounds = ExperienceBounds::From(Config{});
  EXPECT_TRUE(bounds.AllowsPriority(0.0f));
  EXPECT_FALSE(bounds.AllowsPriority(-1.0f));
  EXPECT_FALSE(bounds.AllowsPriority(std::numeric_limits<float>::infinity()));
  EXPECT_FALSE(bounds.AllowsPriority(std::numeric_limits<float>::quiet_NaN()));
}

TEST(ExperienceBounds, DecisionsOutsideTheirColumnsBoundsAreImpossible) {
  StepSpec spec = DrivingStepSpec(DrivingShape{});
  spec.decision.push_back({.name = "log_probability"});
  const auto possible = [&](float first, float second, float third) {
    return IsPossibleDecision(spec, std::array{first, second, third});
  };
  EXPECT_TRUE(possible(-1.0f, 1.0f, -1e30f));
  EXPECT_FALSE(possible(0.0f, 1.001f, 0.0f));
  EXPECT_FALSE(possible(std::numeric_limits<float>::quiet_NaN(), 0.0f, 0.0f));
  EXPECT_FALSE(possible(0.0f, 0.0f, std::numeric_limits<float>::infinity()));
  EXPECT_FALSE(IsPossibleDecision(spec, Action{}));
}

}  // namespace
}  // namespace dadrl
