#include "actor/driving_environment.h"

#include <gtest/gtest.h>
#include <libsumo/libsumo.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "actor/sim/traffic.h"
#include "common/util/random.h"
#include "tests/driving_columns.h"

namespace dadrl {
namespace {

// What an agent saw and got in one episode.
struct Record {
  std::vector<Observation> observations;
  std::vector<float> rewards;
  EpisodeSummary summary;
  bool operator==(const Record&) const = default;
};

Config TestConfig(const std::string& scenario = "left_turn") {
  Config config;
  config.scenario = scenario;
  return config;
}

std::unique_ptr<DrivingEnvironment> Make(const Config& config, const EnvironmentOptions& options = {}) {
  auto environment = DrivingEnvironment::Create(config, options);
  if (!environment) throw std::runtime_error(environment.error().message);
  return std::move(*environment);
}

Record Drive(DrivingEnvironment& environment, uint64_t seed, uint64_t action_seed) {
  Random random(action_seed);
  Record record;
  EXPECT_TRUE(environment.Reset(seed));
  record.observations.push_back(environment.observation());
  for (;;) {
    const Action action{static_cast<float>(random.Uniform(-1, 1)), static_cast<float>(random.Uniform(-1, 1))};
    const auto step = environment.Step(action);
    EXPECT_TRUE(step) << step.error().message;
    if (!step) return record;
    record.observations.push_back(environment.observation());
    record.rewards.push_back(step->reward);
    if (step->ended()) break;
  }
  record.summary = environment.summary();
  return record;
}

TEST(DrivingEnvironment, SameSeedIsTheSameEpisodeBitForBit) {
  const auto environment = Make(TestConfig());
  const Record first = Drive(*environment, 1'000'000, 5);
  const Record other = Drive(*environment, 1'000'001, 5);
  const Record again = Drive(*environment, 1'000'000, 5);
  EXPECT_EQ(first, again);
  EXPECT_NE(first.observations.front(), other.observations.front());
  EXPECT_GT(first.rewards.size(), 5U);
}

TEST(DrivingEnvironment, ObservationIsWholeAndInRange) {
  const auto environment = Make(TestConfig());
  const Record record = Drive(*environment, 1'000'002, 9);
  for (const Observation& observation : record.observations) {
    ASSERT_EQ(VehiclesOf(observation).size(), 6U * 5 * 7);
    ASSERT_EQ(EgoOf(observation).size(), 5U * 20);
    for (const float value : VehiclesOf(observation)) ASSERT_LE(std::abs(value), 5.0f);
    for (const float value : EgoOf(observation)) ASSERT_LE(std::abs(value), 5.0f);
    // The ego is where it is: the newest row is the origin of its own frame.
    EXPECT_EQ(EgoOf(observation)[80], 0.0f);
    EXPECT_NEAR(EgoOf(observation)[81], 0.0, 1e-6);
    EXPECT_NEAR(EgoOf(observation)[83], 1.0, 1e-6);
  }
  EXPECT_EQ(EgoOf(record.observations.front())[60], 1.0f);  // nothing was before the spawn
}

TEST(DrivingEnvironment, ADecisionsRewardIsTheDiscountedSumOfItsSteps) {
  Config config = TestConfig();
  config.algorithm.gamma = 0.729;  // 0.9 a step
  config.task.decision_interval = 3;
  std::vector<double> singles;
  const Action go{0.2f, 0.0f};
  {
    Config each = config;
    each.task.decision_interval = 1;
    const auto environment = Make(each);
    ASSERT_TRUE(environment->Reset(3));
    for (int step = 0; step < 3; ++step) singles.push_back(environment->Step(go)->reward);
  }
  const auto environment = Make(config);
  ASSERT_TRUE(environment->Reset(3));
  EXPECT_NEAR(environment->Step(go)->reward, singles[0] + 0.9 * singles[1] + 0.81 * singles[2], 1e-6);
  EXPECT_EQ(environment->world().step, 3);
}

TEST(DrivingEnvironment, TheTimeLimitTruncatesInsideADecision) {
  Config config = TestConfig();
  config.task.max_steps = 7;
  const auto environment = Make(config);
  ASSERT_TRUE(environment->Reset(4));
  const Action stop{-1.0f, 0.0f};
  EXPECT_FALSE(environment->Step(stop)->ended());
  EXPECT_FALSE(environment->Step(stop)->ended());
  const auto last = environment->Step(stop);
  EXPECT_TRUE(last->truncated);
  EXPECT_FALSE(last->terminated);
  EXPECT_EQ(environment->summary().steps, 7);
  EXPECT_EQ(environment->summary().outcome, Outcome::kStagnation);
  EXPECT_EQ(environment->summary().seed, 4U);
}

TEST(DrivingEnvironment, RefusesActionsThatAreNotFiniteWithoutStepping) {
  const auto environment = Make(TestConfig());
  ASSERT_TRUE(environment->Reset(5));
  const Observation before = environment->observation();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  for (const Action& action : {Action{nan, 0}, Action{0, nan}, Action{infinity, 0}, Action{0, -infinity}}) {
    const auto step = environment->Step(action);
    ASSERT_FALSE(step);
    EXPECT_EQ(step.error().code, ErrorCode::kInvalidArgument);
  }
  EXPECT_FALSE(environment->Drive({nan, 0}, 1));
  EXPECT_FALSE(environment->Drive({-1.0, 0}, 1));
  EXPECT_EQ(environment->observation(), before);
  EXPECT_EQ(environment->world().step, 0);
  EXPECT_TRUE(environment->Step({0, 0}));
}

TEST(DrivingEnvironment, NothingFollowsTheEndOfAnEpisode) {
  Config config = TestConfig();
  config.task.max_steps = 1;
  const auto environment = Make(config);
  EXPECT_FALSE(environment->Step({0, 0}));  // before the first Reset
  ASSERT_TRUE(environment->Reset(6));
  EXPECT_TRUE(environment->Step({0, 0})->ended());
  EXPECT_FALSE(environment->Step({0, 0}));
  EXPECT_TRUE(environment->Reset(6));
  EXPECT_TRUE(environment->Step({0, 0}));
}

TEST(DrivingEnvironment, AnEpisodeLostToTheSimulatorLeavesTheNextOneClean) {
  const auto environment = Make(TestConfig());
  const Record reference = Drive(*environment, 7, 1);
  ASSERT_TRUE(environment->Reset(8));
  ASSERT_TRUE(environment->Step({0, 0}));
  libsumo::Vehicle::remove(kEgoId);
  const auto step = environment->Step({0, 0});
  ASSERT_FALSE(step);
  EXPECT_EQ(step.error().code, ErrorCode::kInternal);
  EXPECT_NE(step.error().message.find("seed 8"), std::string::npos) << step.error().message;
  EXPECT_FALSE(environment->Step({0, 0}));
  EXPECT_EQ(Drive(*environment, 7, 1), reference);
}

TEST(DrivingEnvironment, UnknownScenarioNamesTheNearest) {
  const auto environment = MakeDrivingEnvironment(TestConfig("left_trun"));
  ASSERT_FALSE(environment);
  EXPECT_EQ(environment.error().code, ErrorCode::kInvalidArgument);
  EXPECT_NE(environment.error().message.find("left_turn"), std::string::npos);
}

TEST(DrivingEnvironment, StandingStillAtTheStartIsNoEvent) {
  for (const char* scenario : {"left_turn", "roundabout_a", "roundabout_b", "roundabout_c", "double_merge"}) {
    const auto environment = Make(TestConfig(scenario));
    ASSERT_TRUE(environment->Reset(9)) << scenario;
    const auto step = environment->Drive({0.0, 0}, 1);
    ASSERT_TRUE(step) << scenario << ": " << step.error().message;
    const Events& events = environment->last_step().events;
    EXPECT_FALSE(events.off_road || events.off_route || events.wrong_way || events.goal) << scenario;
    EXPECT_GT(environment->location().remaining, 0.97) << scenario;
  }
}

TEST(DrivingEnvironment, SumosDriverReachesTheGoal) {
  const auto environment = Make(TestConfig("roundabout_a"), {EgoDriver::kSumo, 1.0});
  ASSERT_TRUE(environment->Reset(1'000'000));
  Result<StepResult> step;
  do {
    step = environment->Drive({}, 1);
    ASSERT_TRUE(step) << step.error().message;
  } while (!step->ended());
  EXPECT_EQ(environment->summary().outcome, Outcome::kSuccess);
  EXPECT_GT(environment->summary().progress, 0.97);
}

}  // namespace
}  // namespace dadrl
