#include "actor/policies/scripted_policies.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <vector>

#include "actor/policies/predictive_policy.h"

namespace dadrl {
namespace {

std::unique_ptr<DrivingEnvironment> Make(const std::string& scenario) {
  Config config;
  config.scenario = scenario;
  auto environment = DrivingEnvironment::Create(config);
  if (!environment) throw std::runtime_error(environment.error().message);
  return std::move(*environment);
}

Outcome DriveToTheEnd(DrivingEnvironment& environment, DrivingPolicy& policy, uint64_t seed) {
  EXPECT_TRUE(environment.Reset(seed));
  policy.BeginEpisode(seed);
  for (;;) {
    const Decision decision = policy.Decide(environment);
    const auto step = environment.Drive(decision.command, decision.steps);
    EXPECT_TRUE(step);
    if (!step || step->ended()) return environment.summary().outcome;
  }
}

TEST(RandomPolicy, DrawsFromTheEpisodesSeedAndHoldsEachAction) {
  const auto environment = Make("left_turn");
  ASSERT_TRUE(environment->Reset(1));
  RandomPolicy policy(10);
  const auto draw = [&](uint64_t seed) {
    policy.BeginEpisode(seed);
    std::vector<double> speeds;
    std::set<int> lanes;
    for (int i = 0; i < 100; ++i) {
      const Decision decision = policy.Decide(*environment);
      EXPECT_EQ(decision.steps, 10);
      EXPECT_GE(decision.command.target_speed_mps, 0.0);
      EXPECT_LE(decision.command.target_speed_mps, 10.0);
      speeds.push_back(decision.command.target_speed_mps);
      lanes.insert(decision.command.lane);
    }
    EXPECT_EQ(lanes, (std::set<int>{-1, 0, 1}));
    return speeds;
  };
  EXPECT_EQ(draw(7), draw(7));
  EXPECT_NE(draw(7), draw(8));
}

TEST(ConstantSpeedPolicy, RdmDrivesFasterThanALearnedPolicyMay) {
  const auto environment = Make("roundabout_b");
  auto setup = MakePolicy("rdm", environment->config(), {});
  ASSERT_TRUE(setup);
  double fastest = 0.0;
  for (uint64_t seed = 1'000'000; seed < 1'000'005; ++seed) {
    ASSERT_TRUE(environment->Reset(seed));
    for (bool ended = false; !ended;) {
      const Decision decision = setup->policy->Decide(*environment);
      EXPECT_EQ(decision.command.lane, 0);
      ended = environment->Drive(decision.command, decision.steps)->ended();
      fastest = std::max(fastest, environment->world().ego.speed_mps);
    }
  }
  EXPECT_GT(fastest, 12.0);
}

TEST(LaneTowardsRoute, PointsRightWhereTheRouteChangesToTheRight) {
  const auto environment = Make("double_merge");
  ASSERT_TRUE(environment->Reset(1'000'000));
  EXPECT_EQ(LaneTowardsRoute(*environment), 0);
  std::set<int> commands;
  for (int step = 0; step < 120; ++step) {
    if (environment->Drive({6.0, 0}, 1)->ended()) break;
    commands.insert(LaneTowardsRoute(*environment));
  }
  EXPECT_EQ(commands, (std::set<int>{-1, 0}));
}

TEST(PredictivePolicy, ReachesTheGoalWhereRdmMostlyCrashes) {
  const auto environment = Make("roundabout_b");
  PredictivePolicy predictive;
  ConstantSpeedPolicy rdm(15.0, ConstantSpeedPolicy::Lane::kKeep);
  int successes = 0;
  int crashes = 0;
  for (uint64_t seed = 1'000'000; seed < 1'000'006; ++seed) {
    successes += DriveToTheEnd(*environment, predictive, seed) == Outcome::kSuccess ? 1 : 0;
    crashes += DriveToTheEnd(*environment, rdm, seed) == Outcome::kCollision ? 1 : 0;
  }
  EXPECT_GE(successes, 5);
  EXPECT_GE(crashes, 5);
}

TEST(MakePolicy, KnowsTheScriptedDrivers) {
  EXPECT_THAT(ScriptedPolicyNames(),
              testing::UnorderedElementsAre("random", "rdm", "slow", "idm", "predictive"));
  for (const std::string& name : ScriptedPolicyNames()) {
    const auto setup = MakePolicy(name, Config{}, {});
    ASSERT_TRUE(setup) << name;
    EXPECT_NE(setup->policy, nullptr);
    EXPECT_EQ(setup->environment.driver == EgoDriver::kSumo, name == "idm");
  }
}

TEST(MakePolicy, RefusesWhatItCannotDrive) {
  const auto unknown = MakePolicy("rmd", Config{}, {});
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(unknown.error().message, testing::HasSubstr("predictive"));
  EXPECT_FALSE(MakePolicy("random", Config{}, {.random_hold_steps = 0}));
  EXPECT_FALSE(MakePolicy("idm", Config{}, {.impatience = 1.5}));
}

}  // namespace
}  // namespace dadrl
