// Density and flow of the traffic over fixed seeds, against what was measured for the paper's scenarios.
#include <gtest/gtest.h>

#include <ostream>

#include "actor/sim/simulation.h"

namespace dadrl {
namespace {

struct Expected {
  const char* scenario;
  int population;
  double vehicles;  // in the network, mean over an episode
  double speed_mps;
  double stopped;  // fraction of them slower than 0.1 m/s
};
void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.scenario; }

struct Measured {
  double vehicles = 0.0;
  double speed_mps = 0.0;
  double stopped = 0.0;
};

// Means over the 80 s of an episode, with the ego out of the way.
Measured Measure(Simulation& simulation, uint64_t seed) {
  constexpr int kSteps = 800;
  EXPECT_TRUE(simulation.Reset(seed));
  EgoState away;
  away.pose.position = {-500.0, -500.0};
  Measured mean;
  for (int step = 0; step < kSteps; ++step) {
    EXPECT_TRUE(simulation.Step(away));
    const auto& vehicles = simulation.world().vehicles;
    const auto count = static_cast<double>(vehicles.size());
    mean.vehicles += count / kSteps;
    for (const SocialVehicle& vehicle : vehicles) {
      mean.speed_mps += vehicle.speed_mps / count / kSteps;
      mean.stopped += (vehicle.speed_mps < 0.1) / count / kSteps;
    }
  }
  return mean;
}

class TrafficStatistics : public testing::TestWithParam<Expected> {};

TEST_P(TrafficStatistics, AgreeWithThePapersTraffic) {
  constexpr int kSeeds = 8;
  const Expected& expected = GetParam();
  const Scenario scenario = LoadScenario(expected.scenario).value();
  EXPECT_EQ(scenario.population(), expected.population);
  for (const TrafficProfile profile : {TrafficProfile::kPlain, TrafficProfile::kCalibrated}) {
    SimulationOptions options;
    options.profile = profile;
    const auto simulation = Simulation::Create(scenario, options).value();
    Measured mean;
    for (uint64_t seed = 0; seed < kSeeds; ++seed) {
      const Measured episode = Measure(*simulation, seed);
      EXPECT_LE(episode.vehicles, expected.population);
      EXPECT_GT(episode.speed_mps, 1.0) << "seed " << seed << " is gridlocked";
      mean.vehicles += episode.vehicles / kSeeds;
      mean.speed_mps += episode.speed_mps / kSeeds;
      mean.stopped += episode.stopped / kSeeds;
    }
    EXPECT_NEAR(mean.vehicles, expected.vehicles, 0.08 * expected.vehicles);
    EXPECT_NEAR(mean.speed_mps, expected.speed_mps, 0.12 * expected.speed_mps);
    EXPECT_NEAR(mean.stopped, expected.stopped, 0.06);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenarios, TrafficStatistics,
                         testing::Values(Expected{"left_turn", 20, 18.9, 7.0, 0.16},
                                         Expected{"roundabout_a", 40, 29.3, 4.6, 0.16},
                                         Expected{"roundabout_b", 40, 29.3, 4.6, 0.16},
                                         Expected{"roundabout_c", 36, 26.5, 4.7, 0.16},
                                         Expected{"double_merge", 18, 16.0, 5.2, 0.06}),
                         [](const auto& test) { return std::string(test.param.scenario); });

}  // namespace
}  // namespace dadrl
