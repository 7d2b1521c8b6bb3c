// Memory over many episodes of an exploring driver in one process, as an actor lives; beside it SUMO alone,
// loading and stepping the same traffic as often.
//
// Prints two JSON lines: kB of resident memory gained per 1000 episodes (the slope of a straight line through
// the later three quarters), the environment's and SUMO's own. of_limit is the share of the limit that is
// used; fails when it exceeds 1.
//
//   env_soak [EPISODES [SCENARIO]]     2000 of left_turn
#include <fmt/core.h>
#include <libsumo/libsumo.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "actor/driving_environment.h"
#include "actor/sim/scenario_plan.h"
#include "actor/sim/sumo_traffic.h"
#include "common/util/random.h"
#include "tests/bench/help.h"

namespace dadrl::bench {
namespace {

constexpr int kEpisodes = 2000;
constexpr int kBareSteps = 50;
// Per 1000 episodes. What SUMO keeps of its own loads is about 800; a leak of one kB an episode shows.
constexpr double kLimitKb = 1600.0;

double ResidentKb() {
  long size = 0, resident = 0;
  std::ifstream("/proc/self/statm") >> size >> resident;
  return static_cast<double>(resident * sysconf(_SC_PAGESIZE)) / 1024.0;
}

Status DriveEpisode(DrivingEnvironment& environment, uint64_t seed) {
  // A start that stays blocked is no failure.
  const Status reset = environment.Reset(seed);
  if (!reset) return reset.error().code == ErrorCode::kUnavailable ? Status() : reset;
  Random random(seed);
  for (bool ended = false; !ended;) {
    const Action action{static_cast<float>(random.Uniform(-1, 1)), static_cast<float>(random.Uniform(-1, 1))};
    DADRL_ASSIGN_OR_RETURN(const StepResult step, environment.Step(action));
    (void)environment.observation();
    ended = step.ended();
  }
  return {};
}

// Resident memory after each of `episodes` runs of `episode`.
Result<std::vector<double>> Soak(int episodes, const std::function<Status(uint64_t)>& episode) {
  std::vector<double> resident_kb;
  resident_kb.reserve(static_cast<size_t>(episodes));
  for (int i = 0; i < episodes; ++i) {
    DADRL_RETURN_IF_ERROR(episode(static_cast<uint64_t>(i)));
    resident_kb.push_back(ResidentKb());
  }
  return resident_kb;
}

// Least squares, per 1000 episodes; the first quarter fills caches and does not count.
double SlopeKb(const std::vector<double>& resident_kb) {
  const size_t first = resident_kb.size() / 4;
  const auto count = static_cast<double>(resident_kb.size() - first);
  double mean = 0.0, covariance = 0.0, variance = 0.0;
  for (size_t i = first; i < resident_kb.size(); ++i) mean += resident_kb[i] / count;
  for (size_t i = first; i < resident_kb.size(); ++i) {
    const double x = static_cast<double>(i - first) - (count - 1) / 2;
    covariance += x * (resident_kb[i] - mean);
    variance += x * x;
  }
  return 1000.0 * covariance / variance;
}

bool Print(const std::string& name, const std::vector<double>& resident_kb) {
  const double slope = SlopeKb(resident_kb);
  fmt::print(
      R"({{"bench": "env_soak", "case": "{}", "value": {:.4g}, "unit": "kB per 1000 episodes", "limit": {:.4g}, )"
      R"("of_limit": {:.3f}, "episodes": {}, "resident_kb": {:.0f}}})"
      "\n",
      name, slope, kLimitKb, slope / kLimitKb, resident_kb.size(), resident_kb.back());
  return slope <= kLimitKb;
}

Result<bool> Run(int episodes, const std::string& name) {
  Config config;
  config.scenario = name;
  DADRL_ASSIGN_OR_RETURN(const auto environment, DrivingEnvironment::Create(config));
  DADRL_ASSIGN_OR_RETURN(const auto whole,
                         Soak(episodes, [&](uint64_t seed) { return DriveEpisode(*environment, seed); }));
  const bool flat = Print(name, whole);

  DADRL_ASSIGN_OR_RETURN(const Scenario scenario, LoadScenario(name));
  DADRL_ASSIGN_OR_RETURN(const ScenarioPlan plan, LoadPlan(scenario, TrafficProfile::kCalibrated));
  DADRL_ASSIGN_OR_RETURN(MemoryFile file, MemoryFile::Create("bench-traffic"));
  SumoTraffic traffic(scenario, scenario.profile(config.traffic.profile), plan, std::move(file));
  const auto bare = Soak(episodes, [&](uint64_t seed) -> Status {
    DADRL_RETURN_IF_ERROR(traffic.Load(seed, EgoTraffic{.edges = {plan.ego_edges.front()}}));
    for (int step = 0; step < kBareSteps; ++step) traffic.Step();
    return {};
  });
  if (!bare) return tl::unexpected<Error>(bare.error());
  Print(name + " SUMO alone", *bare);
  return flat;
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  if (dadrl::bench::HelpAsked(
          argc, argv, "env_soak [EPISODES [SCENARIO]]: memory over many episodes; 2000 of left_turn\n")) {
    return 0;
  }
  const int episodes = argc > 1 ? std::atoi(argv[1]) : dadrl::bench::kEpisodes;
  if (episodes < 8 || argc > 3) {
    fmt::print(stderr, "usage: env_soak [EPISODES [SCENARIO]]: at least 8 episodes\n");
    return 2;
  }
  const auto flat = dadrl::bench::Run(episodes, argc > 2 ? argv[2] : "left_turn");
  if (!flat) fmt::print(stderr, "error: {}\n", flat.error().message);
  return flat ? (*flat ? 0 : 1) : dadrl::ExitCode(flat.error());
}
