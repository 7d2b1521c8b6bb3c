#include "actor/task/driving_task.h"

#include <gtest/gtest.h>

#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

class DrivingTaskTest : public testing::Test {
 protected:
  void Begin(double x) {
    localizer_.Reset();
    task_.Begin("somewhere", 42, localizer_.Locate({{x, 0}, 0.0}));
  }
  TaskStep Step(double x, double y = 0.0, double speed = 10.0) {
    const WorldState world = test::WorldWithEgo(x, y, 0.0, speed);
    return task_.Step(world, localizer_.Locate(world.ego.pose));
  }
  static TaskConfig ShortTask() {
    TaskConfig config;
    config.max_steps = 5;
    return config;
  }

  RoadMap map_ = test::StraightRoad();
  Route route_ = test::StraightRoute(map_);
  Localizer localizer_{map_, route_};
  DrivingTask task_{map_, route_, ShortTask()};
};

// From x = 105 (95 % driven) at the limit: two steps, then within 2 m of x = 110.
TEST_F(DrivingTaskTest, ReachingTheGoalEndsInSuccessWithTheReturnOfEveryTerm) {
  Begin(105);
  EXPECT_FALSE(Step(106).ended());
  EXPECT_FALSE(Step(107).ended());
  const TaskStep last = Step(108.1);
  EXPECT_TRUE(last.terminated);
  EXPECT_FALSE(last.truncated);
  const EpisodeSummary& summary = task_.summary();
  EXPECT_EQ(summary.scenario, "somewhere");
  EXPECT_EQ(summary.seed, 42U);
  EXPECT_FALSE(summary.collision);
  EXPECT_EQ(summary.outcome, Outcome::kSuccess);
  EXPECT_EQ(summary.steps, 3);
  EXPECT_NEAR(summary.episode_return, 3.0 + 2.0 * 0.031 + 3 * 0.01, 1e-9);
  EXPECT_NEAR(summary.progress, 0.981, 1e-9);
  EXPECT_NEAR(summary.time_cost, 0.6, 1e-12);
}

TEST_F(DrivingTaskTest, TheTimeLimitTruncatesAndIsStagnation) {
  Begin(20);
  for (int step = 0; step < 4; ++step) EXPECT_FALSE(Step(20, 0, 0).ended());
  const TaskStep last = Step(20, 0, 0);
  EXPECT_TRUE(last.truncated);
  EXPECT_FALSE(last.terminated);
  EXPECT_EQ(task_.summary().outcome, Outcome::kStagnation);
  EXPECT_NEAR(task_.summary().distance_to_destination, 0.9, 1e-9);
}

TEST_F(DrivingTaskTest, AnEndInTheLastStepIsATerminationNotATruncation) {
  Begin(104);
  for (int step = 0; step < 4; ++step) Step(105);
  const TaskStep last = Step(109);
  EXPECT_TRUE(last.terminated);
  EXPECT_FALSE(last.truncated);
}

TEST_F(DrivingTaskTest, LeavingTheRoadEndsTheEpisode) {
  Begin(20);
  EXPECT_TRUE(Step(21, -1.8).terminated);
  EXPECT_EQ(task_.summary().outcome, Outcome::kOffRoad);
}

TEST_F(DrivingTaskTest, ContactEndsTheEpisodeEvenAtTheGoal) {
  Begin(108);
  WorldState world = test::WorldWithEgo(109, 0);
  world.vehicles = {test::Vehicle(0, 112, 0)};
  EXPECT_TRUE(task_.Step(world, localizer_.Locate(world.ego.pose)).terminated);
  EXPECT_EQ(task_.summary().outcome, Outcome::kCollision);
  ASSERT_TRUE(task_.summary().collision);
  EXPECT_EQ(task_.summary().collision->side, ContactSide::kFront);
  EXPECT_LT(task_.summary().episode_return, 0.0);
}

TEST_F(DrivingTaskTest, LeavingTheNetworkIsSuccessOnlyAtTheGoal) {
  const auto leave = [&](double x, double y) {
    Begin(105);
    const WorldState world = test::WorldWithEgo(x, y);
    EXPECT_TRUE(task_.Leave(world, localizer_.Locate(world.ego.pose)).terminated);
    return task_.summary().outcome;
  };
  EXPECT_EQ(leave(108.2, 0.0), Outcome::kSuccess);
  EXPECT_EQ(leave(108.2, 3.2), Outcome::kOffRoad);
}

TEST_F(DrivingTaskTest, ANewEpisodeStartsFromZero) {
  Begin(20);
  Step(21, -1.8);
  Begin(20);
  Step(21);
  EXPECT_EQ(task_.summary().steps, 1);
  EXPECT_FALSE(task_.summary().collision);
  EXPECT_NEAR(task_.summary().episode_return, 0.03, 1e-9);
}

}  // namespace
}  // namespace dadrl
