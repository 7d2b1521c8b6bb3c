// Roads that people bring: each folder of roads/ has something that the shipped scenarios have not.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <set>

#include "actor/evaluation/evaluation.h"
#include "actor/sim/scenario.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

constexpr const char* kRoads = DADRL_SOURCE_DIR "/tests/actor/roads";
constexpr int kEpisodes = 5;

std::unique_ptr<DrivingEnvironment> MakeEnvironment(const std::string& scenario,
                                                    EgoDriver driver = EgoDriver::kCaller) {
  setenv("DADRL_SCENARIOS", kRoads, 1);
  Config config;
  config.scenario = scenario;
  auto environment = DrivingEnvironment::Create(config, {.driver = driver});
  EXPECT_TRUE(environment) << environment.error().message;
  return environment ? std::move(*environment) : nullptr;
}

std::vector<EvaluatedEpisode> Drive(const std::string& scenario, const std::string& policy) {
  setenv("DADRL_SCENARIOS", kRoads, 1);
  EvaluationOptions options;
  options.config.scenario = scenario;
  options.policy = policy;
  for (int i = 0; i < kEpisodes; ++i)
    options.episodes.push_back({.group = 0, .seed = 1'000'000 + uint64_t(i)});
  const auto report = RunEvaluation(options);
  EXPECT_TRUE(report) << report.error().message;
  return report ? report->episodes : std::vector<EvaluatedEpisode>{};
}

int Successes(const std::vector<EvaluatedEpisode>& episodes) {
  return static_cast<int>(std::ranges::count_if(episodes, [](const EvaluatedEpisode& episode) {
    return !episode.lost() && episode.summary.outcome == Outcome::kSuccess;
  }));
}

class OwnRoads : public testing::TestWithParam<const char*> {};

// No road of these is hard: SUMO's own driver and ours come through.
TEST_P(OwnRoads, ArePassableForTheRuleDrivers) {
  EXPECT_EQ(Successes(Drive(GetParam(), "idm")), kEpisodes);
  EXPECT_EQ(Successes(Drive(GetParam(), "predictive")), kEpisodes);
}

INSTANTIATE_TEST_SUITE_P(All, OwnRoads,
                         testing::Values("crosswalks", "cycle_lane", "lorries", "overpass", "own_vehicles",
                                         "small_grid", "speed_change"),
                         [](const auto& road) { return std::string(road.param); });

TEST(OwnRoad, PavementsAndCrossingsAreNotOfTheMap) {
  const auto environment = MakeEnvironment("crosswalks");
  for (const Lane& lane : environment->map().lanes()) {
    EXPECT_THAT(lane.id, testing::Not(testing::AnyOf(HasSubstr("_w"), HasSubstr("_c")))) << lane.width;
    EXPECT_GE(lane.centre.points().size(), 2u) << lane.id;
  }
  EXPECT_GE(environment->map().FindLane("SJ_1"), 0);
  EXPECT_EQ(environment->map().FindLane("SJ_0"), -1);
}

TEST(OwnRoad, TheChangeOfALimitOnAStraightIsDrivenThrough) {
  const auto environment = MakeEnvironment("speed_change");
  const Route& route = environment->route();
  EXPECT_EQ(route.lanes().size(), 2u);
  EXPECT_TRUE(std::isfinite(route.length()));
  ASSERT_TRUE(environment->Reset(1));
  EXPECT_EQ(environment->location().speed_limit,
            environment->map().lanes()[static_cast<size_t>(route.lanes()[0])].speed_limit);
}

TEST(OwnRoad, CarsEnterAgainOnlyOnLanesTheyMayUse) {
  const auto environment = MakeEnvironment("cycle_lane", EgoDriver::kSumo);
  ASSERT_TRUE(environment->Reset(3));
  std::set<int> trips;
  for (bool runs = true; runs;) {
    for (const SocialVehicle& vehicle : environment->world().vehicles) {
      EXPECT_EQ(vehicle.lane_index, 1);
      trips.insert(vehicle.trip);
    }
    const auto step = environment->Drive({}, 1);
    ASSERT_TRUE(step) << step.error().message;
    runs = !step->terminated && !step->truncated;
  }
  EXPECT_GT(trips.size(), 1u);  // some did enter again
}

TEST(OwnRoad, TheStepIsNotForScenarios) {
  const auto scenario = LoadScenario("coarse_step", kRoads);
  ASSERT_FALSE(scenario);
  EXPECT_THAT(scenario.error().message, HasSubstr(":14: "));
  EXPECT_THAT(scenario.error().message, HasSubstr("'step-length' is not for scenarios: a step is 0.1 s"));
}

TEST(OwnRoad, WhoDrivesOverABridgeIsNotInTheScene) {
  const auto environment = MakeEnvironment("overpass");
  for (const uint64_t seed : {1u, 2u, 3u}) {
    ASSERT_TRUE(environment->Reset(seed));
    EXPECT_EQ(environment->world().ego.elevation_m, 0.0);
    for (bool runs = true; runs;) {
      for (const SocialVehicle& vehicle : environment->world().vehicles) {
        // Far away, where a road could have climbed.
        EXPECT_GT(Norm(vehicle.pose.position - environment->world().ego.pose.position), 50.0);
      }
      const auto step = environment->Drive({8.0, 0}, 1);
      ASSERT_TRUE(step);
      runs = !step->terminated && !step->truncated;
    }
    EXPECT_EQ(environment->summary().outcome, Outcome::kSuccess);
  }
}

TEST(OwnRoad, LorriesAreAsLongAndWideAsTheirDriversSay) {
  const auto environment = MakeEnvironment("lorries");
  ASSERT_TRUE(environment->Reset(1));
  ASSERT_FALSE(environment->world().vehicles.empty());
  for (const SocialVehicle& vehicle : environment->world().vehicles) {
    EXPECT_EQ(vehicle.length_m, 16.5);
    EXPECT_EQ(vehicle.width_m, 2.5);
  }
}

// The bus line is in a file of the scenario's own, named without a folder.
TEST(OwnRoad, VehiclesOfTheScenariosFilesAreSeenLikeTheOthers) {
  const auto environment = MakeEnvironment("own_vehicles", EgoDriver::kSumo);
  ASSERT_TRUE(environment->Reset(1));
  std::set<int> buses;
  for (bool runs = true; runs;) {
    for (const SocialVehicle& vehicle : environment->world().vehicles) {
      if (vehicle.id < 16) continue;
      buses.insert(vehicle.id);
      EXPECT_EQ(vehicle.length_m, 12.0);
      EXPECT_GT(vehicle.width_m, 2.0);
    }
    const auto step = environment->Drive({}, 1);
    ASSERT_TRUE(step) << step.error().message;
    runs = !step->terminated && !step->truncated;
  }
  EXPECT_FALSE(buses.empty());
}

}  // namespace
}  // namespace dadrl
