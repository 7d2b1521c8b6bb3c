#include "actor/collect/scripted_driver.h"

#include <gtest/gtest.h>

#include <cmath>

#include "actor/driving_environment.h"

namespace dadrl {
namespace {

TEST(ActionOf, AsksForTheCommandAgainAndForNoMoreSpeedThanThereIs) {
  for (const double speed : {0.0, 3.0, 10.0}) {
    for (const int lane : {-1, 0, 1}) {
      const Action action = ActionOf({speed, lane}, 10.0);
      const DriveCommand command = CommandOf(action, 10.0);
      EXPECT_NEAR(command.target_speed_mps, speed, 1e-5);
      EXPECT_EQ(command.lane, lane);
      for (const float element : action) EXPECT_LE(std::abs(element), 1.0f);
    }
  }
  EXPECT_EQ(CommandOf(ActionOf({15.0, 0}, 10.0), 10.0).target_speed_mps, 10.0);
}

TEST(ScriptedDriver, IsNoneForTheLearnersPolicy) {
  EXPECT_EQ(ScriptedDriver::Make(Config{}).value(), nullptr);
}

// Held for a decision of three steps, what it predicts must not depend on how often it is asked.
TEST(ScriptedDriver, ThePredictiveOneDrivesDecisionsAsItDrivesSteps) {
  Config config;
  config.actor.policy = "predictive";
  const auto environment = MakeDrivingEnvironment(config).value();
  const auto driver = ScriptedDriver::Make(config).value();
  int goals = 0;
  constexpr int kEpisodes = 20;
  for (uint64_t seed = 1; seed <= kEpisodes; ++seed) {
    ASSERT_TRUE(environment->Reset(seed));
    driver->BeginEpisode(seed);
    StepResult step;
    while (!step.ended()) step = environment->Step(driver->Act(*environment)).value();
    goals += environment->summary().outcome == Outcome::kSuccess;
  }
  EXPECT_GE(goals, 18);
}

TEST(ScriptedDriver, AllScenariosAreDrivenToo) {
  Config config;
  config.scenario = "all";
  config.actor.policy = "rdm";
  const auto environment = MakeDrivingEnvironment(config).value();
  const auto driver = ScriptedDriver::Make(config).value();
  for (uint64_t seed = 1; seed <= 3; ++seed) {
    ASSERT_TRUE(environment->Reset(seed));
    driver->BeginEpisode(seed);
    EXPECT_TRUE(environment->Step(driver->Act(*environment)));
  }
}

}  // namespace
}  // namespace dadrl
