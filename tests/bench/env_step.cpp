// The whole environment step (control, traffic, box tests, histories, both planes, reward) beside SUMO's bare
// step on the same traffic: the same seeds, the ego at the same places, nothing read. The call that places
// the ego is part of both: without it the traffic would be another; place_us is its share of the bare step.
//
// Prints three JSON lines a scenario: the ratio of the two, as an actor runs (an observation a decision),
// with its limit of 1.5; the same with an observation every step; and the median reset with its limit of 25
// ms. of_limit is the share of the limit that is used. Fails when the bare traffic was another.
//
//   env_step [SCENARIO...]     without names: all
#include <fmt/core.h>
#include <libsumo/libsumo.h>

#include <cmath>
#include <cstring>
#include <memory>
#include <string>
#include <vector>

#include "actor/driving_environment.h"
#include "actor/sim/scenario_plan.h"
#include "actor/sim/sumo_pose.h"
#include "actor/sim/sumo_traffic.h"
#include "common/util/random.h"
#include "tests/bench/core_peak.h"
#include "tests/bench/help.h"

namespace dadrl::bench {
namespace {

constexpr int kSteps = 4000;
constexpr int kHoldSteps = 10;
constexpr double kStepLimit = 1.5;
constexpr double kResetLimitMs = 25.0;

// An episode as it was driven.
struct Drive {
  uint64_t seed = 0;
  long steps_before_spawn = 0;
  std::vector<EgoState> ego;                // where the ego was put, step by step
  std::vector<SocialVehicle> last_traffic;  // after the last step
  double reset_s = 0.0;
  double step_s = 0.0;  // all steps together
};

bool Same(const std::vector<SocialVehicle>& a, const std::vector<SocialVehicle>& b) {
  if (a.size() != b.size()) return false;
  for (size_t i = 0; i < a.size(); ++i) {
    if (a[i].id != b[i].id || a[i].lane_index != b[i].lane_index || a[i].speed_mps != b[i].speed_mps ||
        std::memcmp(&a[i].pose, &b[i].pose, sizeof a[i].pose) != 0) {
      return false;
    }
  }
  return true;
}

// An exploring driver that keeps its lane: speeds drawn from the seed. It looks every `decision_steps`.
Result<Drive> DriveEpisode(DrivingEnvironment& environment, uint64_t seed, size_t decision_steps) {
  Drive drive;
  drive.seed = seed;
  double begin = Seconds();
  DADRL_RETURN_IF_ERROR(environment.Reset(seed));
  drive.reset_s = Seconds() - begin;
  drive.steps_before_spawn = std::lround(libsumo::Simulation::getTime() / kStepSeconds);
  Random random(seed);
  DriveCommand command;
  for (bool ended = false; !ended;) {
    if (drive.ego.size() % kHoldSteps == 0) command.target_speed_mps = random.Uniform(0.0, 10.0);
    begin = Seconds();
    DADRL_ASSIGN_OR_RETURN(const StepResult step, environment.Drive(command, 1));
    if ((drive.ego.size() + 1) % decision_steps == 0) (void)environment.observation();
    drive.step_s += Seconds() - begin;
    drive.ego.push_back(environment.world().ego);
    ended = step.ended();
  }
  drive.last_traffic = environment.world().vehicles;
  return drive;
}

// Seconds of SUMO alone, all steps together.
struct BareTime {
  double place_s = 0.0;  // where the ego is
  double step_s = 0.0;
};

// For the same steps.
Result<BareTime> DriveBare(SumoTraffic& traffic, const ScenarioPlan& plan, const Drive& drive) {
  DADRL_RETURN_IF_ERROR(traffic.Load(drive.seed, EgoTraffic{.edges = {plan.ego_edges.front()}}));
  for (long step = 0; step < drive.steps_before_spawn; ++step) traffic.Step();
  traffic.AddDrivenEgo();
  BareTime time;
  for (const EgoState& ego : drive.ego) {
    const double begin = Seconds();
    MoveInSumo(kEgoId, ego.pose, ego.speed_mps);
    const double placed = Seconds();
    traffic.Step();
    time.place_s += placed - begin;
    time.step_s += Seconds() - placed;
  }
  std::vector<SocialVehicle> vehicles;
  DADRL_RETURN_IF_ERROR(traffic.Read(vehicles));
  if (Same(vehicles, drive.last_traffic)) return time;
  return Fail(ErrorCode::kInternal, "seed {}: the bare traffic is not the environment's", drive.seed);
}

void Print(const std::string& name, double value, const char* unit, double limit, const std::string& more) {
  fmt::print(R"({{"bench": "env_step", "case": "{}", "value": {:.4g}, "unit": "{}", "limit": {:.4g}, )"
             R"("of_limit": {:.3f}{}}})"
             "\n",
             name, value, unit, limit, value / limit, more);
}

// One scenario's environment, and SUMO alone on its traffic.
class Bench {
 public:
  static Result<Bench> Create(const std::string& name) {
    Config config;
    config.scenario = name;
    DADRL_ASSIGN_OR_RETURN(auto environment, DrivingEnvironment::Create(config));
    DADRL_ASSIGN_OR_RETURN(auto scenario, LoadScenario(name));
    DADRL_ASSIGN_OR_RETURN(auto plan, LoadPlan(scenario, TrafficProfile::kCalibrated));
    DADRL_ASSIGN_OR_RETURN(MemoryFile file, MemoryFile::Create("bench-traffic"));
    return Bench(std::move(environment), std::make_unique<Scenario>(std::move(scenario)),
                 std::make_unique<ScenarioPlan>(std::move(plan)), std::move(file));
  }

  Status Measure(const std::string& name, size_t decision_steps) {
    size_t steps = 0;
    double whole_s = 0.0;
    BareTime bare;
    for (uint64_t seed = 0; steps < kSteps; ++seed) {
      DADRL_ASSIGN_OR_RETURN(const Drive drive, DriveEpisode(*environment_, seed, decision_steps));
      DADRL_ASSIGN_OR_RETURN(const BareTime time, DriveBare(*bare_, *plan_, drive));
      steps += drive.ego.size();
      whole_s += drive.step_s;
      bare.place_s += time.place_s;
      bare.step_s += time.step_s;
      resets_ms_.push_back(1e3 * drive.reset_s);
    }
    const double us = 1e6 / static_cast<double>(steps);
    const double bare_s = bare.place_s + bare.step_s;
    Print(name, whole_s / bare_s, "bare SUMO steps", kStepLimit,
          fmt::format(R"(, "step_us": {:.4g}, "bare_us": {:.4g}, "place_us": {:.4g})", us * whole_s,
                      us * bare_s, us * bare.place_s));
    return {};
  }

  double median_reset_ms() const { return Quantile(resets_ms_, 0.5); }

 private:
  Bench(std::unique_ptr<DrivingEnvironment> environment, std::unique_ptr<Scenario> scenario,
        std::unique_ptr<ScenarioPlan> plan, MemoryFile file)
      : environment_(std::move(environment)),
        scenario_(std::move(scenario)),
        plan_(std::move(plan)),
        bare_(std::make_unique<SumoTraffic>(*scenario_,
                                            scenario_->profile(environment_->config().traffic.profile),
                                            *plan_, std::move(file))) {}

  std::unique_ptr<DrivingEnvironment> environment_;
  std::unique_ptr<Scenario> scenario_;
  std::unique_ptr<ScenarioPlan> plan_;
  std::unique_ptr<SumoTraffic> bare_;
  std::vector<double> resets_ms_;
};

Status MeasureScenario(const std::string& name) {
  DADRL_ASSIGN_OR_RETURN(Bench bench, Bench::Create(name));
  DADRL_RETURN_IF_ERROR(bench.Measure(name, static_cast<size_t>(TaskConfig().decision_interval)));
  DADRL_RETURN_IF_ERROR(bench.Measure(name + ", a look every step", 1));
  Print(name + " reset", bench.median_reset_ms(), "ms", kResetLimitMs, "");
  return {};
}

int Main(std::vector<std::string> names) {
  if (names.empty()) names = ScenarioNames();
  for (const std::string& name : names) {
    if (const Status status = MeasureScenario(name); !status) {
      fmt::print(stderr, "error: {}\n", status.error().message);
      return ExitCode(status.error());
    }
  }
  return 0;
}

}  // namespace
}  // namespace dadrl::bench

int main(int argc, char** argv) {
  if (dadrl::bench::HelpAsked(argc, argv,
                              "env_step [SCENARIO...]: the environment step beside SUMO's bare one\n")) {
    return 0;
  }
  return dadrl::bench::Main({argv + 1, argv + argc});
}
