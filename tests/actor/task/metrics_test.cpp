#include "actor/task/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/actor/test_maps.h"

namespace dadrl {
namespace {

constexpr double kDegree = std::numbers::pi / 180.0;

TEST(ObstacleCost, DecaysWithDistance) {
  WorldState world = test::WorldWithEgo(0, 0, 0, 10);
  world.vehicles = {test::Vehicle(0, 20, 0), test::Vehicle(1, 8, 6)};
  EXPECT_NEAR(ObstacleCost(world), std::exp(-0.05 * 10), 1e-12);
}

TEST(ObstacleCost, LooksThreeSecondsAndThirtyMetresAhead) {
  WorldState world = test::WorldWithEgo(0, 0, 0, 4);
  world.vehicles = {test::Vehicle(0, 12.1, 0)};
  EXPECT_EQ(ObstacleCost(world), 0.0);
  world.ego.speed_mps = 4.1;
  EXPECT_GT(ObstacleCost(world), 0.0);
  world.ego.speed_mps = 20;
  world.vehicles = {test::Vehicle(0, 30.1, 0)};
  EXPECT_EQ(ObstacleCost(world), 0.0);
}

TEST(ObstacleCost, IgnoresWhatIsAsideOrExactlyOncoming) {
  WorldState world = test::WorldWithEgo(0, 0, 0, 10);
  const auto cost = [&](double bearing, double heading) {
    world.vehicles = {test::Vehicle(0, 10 * std::cos(bearing * kDegree), 10 * std::sin(bearing * kDegree),
                                    heading * kDegree)};
    return ObstacleCost(world);
  };
  EXPECT_GT(cost(39, 0), 0.0);
  EXPECT_EQ(cost(41, 0), 0.0);
  EXPECT_EQ(cost(-41, 0), 0.0);
  EXPECT_GT(cost(0, 178), 0.0);
  EXPECT_EQ(cost(0, 180), 0.0);
}

TEST(JerkCost, IsInMetresPerSecondCubed) {
  EgoState ego;
  ego.jerk_lon = 0.45;
  ego.jerk_lat = -0.45;
  EXPECT_NEAR(JerkCost(ego), 0.5, 1e-12);
  ego.jerk_lon = 5.0;
  EXPECT_EQ(JerkCost(ego), 1.0);
}

TEST(LaneOffsetCost, IsTheSquareOfHalfLaneWidths) {
  const RoadMap map = test::StraightRoad();
  const Route route = test::StraightRoute(map);
  Localizer localizer(map, route);
  EXPECT_NEAR(LaneOffsetCost(localizer.Locate({{50, -0.8}, 0}), map), 0.25, 1e-9);
  EXPECT_NEAR(LaneOffsetCost(localizer.Locate({{50, -2.4}, 0}), map), 1.0, 1e-9);
  EXPECT_EQ(LaneOffsetCost(localizer.Locate({{50, -6.0}, 0}), map), 0.0);
}

TEST(SpeedingCost, SaturatesAtHalfAboveTheLimit) {
  EXPECT_EQ(SpeedingCost(8.0, 8.0), 0.0);
  EXPECT_NEAR(SpeedingCost(10.0, 8.0), 0.25, 1e-12);
  EXPECT_EQ(SpeedingCost(20.0, 8.0), 1.0);
  EXPECT_EQ(SpeedingCost(20.0, 0.0), 0.0);
}

class EpisodeMetricsTest : public testing::Test {
 protected:
  // Four steps: obstacle exp(-0.5) in the first only, jerk cost 0.5 in two, offset 0.25 in one, 25 %
  // speeding cost in two, against the lane in one; speeds 10, 10, 12.5, 12.5.
  EpisodeSummary Drive(Outcome outcome) {
    metrics_.Begin();
    for (int step = 0; step < 4; ++step) {
      WorldState world = test::WorldWithEgo(50, step == 3 ? 0.8 : 0.0, 0, step < 2 ? 10 : 12.5);
      if (step == 0) world.vehicles = {test::Vehicle(0, 60, 0)};
      if (step < 2) world.ego.jerk_lon = 0.5 * std::hypot(0.9, 0.9);
      Events events;
      events.wrong_way = step == 1;
      metrics_.Step(world, localizer_.Locate(world.ego.pose), events);
    }
    EpisodeSummary summary;
    summary.outcome = outcome;
    summary.steps = 4;
    summary.progress = 0.4;
    metrics_.Finish(16, summary);
    return summary;
  }

  RoadMap map_ = test::StraightRoad();
  Route route_ = test::StraightRoute(map_);
  Localizer localizer_{map_, route_};
  EpisodeMetrics metrics_{map_};
};

TEST_F(EpisodeMetricsTest, AveragesOverAllSteps) {
  const EpisodeSummary summary = Drive(Outcome::kCollision);
  EXPECT_NEAR(summary.mean_speed_mps, 11.25, 1e-12);
  EXPECT_NEAR(summary.obstacle_cost, std::exp(-0.5) / 4, 1e-12);
  EXPECT_NEAR(summary.jerk_cost, 0.25, 1e-12);
  EXPECT_NEAR(summary.lane_offset_cost, 0.0625, 1e-9);
  EXPECT_NEAR(summary.humanness_error, (std::exp(-0.5) / 4 + 0.25 + 0.0625) / 3, 1e-9);
  EXPECT_NEAR(summary.rule_violation, (0.125 + 0.25) / 2, 1e-12);
}

TEST_F(EpisodeMetricsTest, FailureCostsAllTheTimeAndTheDistanceLeft) {
  const EpisodeSummary summary = Drive(Outcome::kCollision);
  EXPECT_NEAR(summary.distance_to_destination, 0.6, 1e-12);
  EXPECT_EQ(summary.time_cost, 1.0);
  EXPECT_NEAR(summary.overall_score,
              0.25 * (0.4 + 0.0 + (1 - summary.humanness_error) + (1 - summary.rule_violation)), 1e-12);
}

TEST_F(EpisodeMetricsTest, SuccessCostsTheTimeItTook) {
  const EpisodeSummary summary = Drive(Outcome::kSuccess);
  EXPECT_EQ(summary.distance_to_destination, 0.0);
  EXPECT_NEAR(summary.time_cost, 0.25, 1e-12);
}

TEST_F(EpisodeMetricsTest, BeginForgetsTheLastEpisode) {
  const EpisodeSummary first = Drive(Outcome::kStagnation);
  EXPECT_EQ(first, Drive(Outcome::kStagnation));
}

}  // namespace
}  // namespace dadrl
