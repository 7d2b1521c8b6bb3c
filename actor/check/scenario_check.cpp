#include "actor/check/scenario_check.h"

#include <sys/resource.h>

#include <algorithm>
#include <utility>

#include "actor/check/scenario_warnings.h"
#include "actor/sim/network_survey.h"
#include "common/util/clock.h"

namespace dadrl {
namespace {

// Any will do; an episode whose start stays blocked says nothing about the next one.
constexpr uint64_t kTrialSeeds = 3;
constexpr int kTrialSteps = 100;

double SecondsSince(TimePoint begin) {
  return std::chrono::duration<double>(SystemClock().Now() - begin).count();
}

double PeakMemory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) * 1024.0;
}

// Its seed.
Result<uint64_t> StartEpisode(DrivingEnvironment& environment, ScenarioCost& cost) {
  Status started;
  for (uint64_t seed = 1; seed <= kTrialSeeds; ++seed) {
    const TimePoint begin = SystemClock().Now();
    started = environment.Reset(seed);
    cost.reset_s = SecondsSince(begin);
    if (started) return seed;
    if (started.error().code != ErrorCode::kUnavailable) return tl::unexpected<Error>(started.error());
  }
  return Fail(ErrorCode::kInvalidArgument,
              "{}, in each of {} episodes; keep the start free: let no flow depart there, or move "
              "ego.start_offset_m",
              started.error().message, kTrialSeeds);
}

Status MeasureSteps(DrivingEnvironment& environment, ScenarioCost& cost) {
  const int interval = environment.config().task.decision_interval;
  const TimePoint begin = SystemClock().Now();
  int steps = 0;
  for (bool runs = true; runs && steps < kTrialSteps; steps += interval) {
    DADRL_ASSIGN_OR_RETURN(const StepResult step, environment.Step({0.0f, 0.0f}));
    environment.observation();
    runs = !step.ended();
  }
  cost.steps_per_s = steps / SecondsSince(begin);
  cost.memory_bytes = PeakMemory();
  return {};
}

RouteFacts FactsOfRoute(const DrivingEnvironment& environment, const Scenario& scenario) {
  const RoadMap& map = environment.map();
  const Route& route = environment.route();
  RouteFacts facts{
      .lanes = scenario.ego_lanes, .length_m = route.length(), .start_offset_m = scenario.ego_start_offset_m};
  facts.paths = static_cast<int>(environment.controller().paths().size());
  facts.min_limit_mps = facts.max_limit_mps = map.lane(route.lanes().front()).speed_limit;
  const Lane* before = nullptr;
  for (const int index : route.lanes()) {
    const Lane& lane = map.lane(index);
    facts.min_limit_mps = std::min(facts.min_limit_mps, lane.speed_limit);
    facts.max_limit_mps = std::max(facts.max_limit_mps, lane.speed_limit);
    if (before != nullptr) {
      facts.junctions += !before->internal && lane.edge != before->edge ? 1 : 0;
      facts.lane_changes += lane.edge == before->edge && !lane.internal ? 1 : 0;
    }
    before = &lane;
  }
  facts.shortest_s = route.length() / environment.config().task.max_speed_mps;
  return facts;
}

std::vector<FlowFacts> FactsOfFlows(const DrivingEnvironment& environment, const Scenario& scenario) {
  std::vector<FlowFacts> flows;
  for (const TrafficFlow& flow : scenario.flows) {
    flows.push_back({.edges = flow.edges,
                     .length_m = FlowLength(environment.map(), flow),
                     .vehicles = scenario.driver_types,
                     .meets_route = MeetsRoute(environment.map(), flow, environment.route())});
  }
  for (const SocialVehicle& vehicle : environment.world().vehicles) {
    const size_t flow = static_cast<size_t>(vehicle.id / scenario.driver_types);
    if (flow < flows.size()) ++flows[flow].entered;
  }
  return flows;
}

ScenarioReport MakeReport(const DrivingEnvironment& environment, const Scenario& scenario) {
  const Config& config = environment.config();
  ScenarioReport report;
  report.name = scenario.name;
  report.file = scenario.file;
  report.network = scenario.network;
  report.survey = SurveySumoNetwork();
  report.extent = ExtentOf(environment.map());
  report.is_cut = environment.network_is_cut();
  report.has_levels = environment.map().has_levels();
  for (const Lane& lane : environment.map().lanes())
    report.road_m += lane.internal ? 0.0 : lane.centre.length();
  report.profile = config.traffic.profile == TrafficProfile::kPlain ? "plain" : "calibrated";
  report.warm_up_s = scenario.warm_up_s;
  report.max_speed_mps = config.task.max_speed_mps;
  report.time_limit_s = config.task.max_steps * kStepSeconds;
  report.route = FactsOfRoute(environment, scenario);
  report.flows = FactsOfFlows(environment, scenario);
  report.others =
      static_cast<int>(std::ranges::count_if(environment.world().vehicles, [&](const auto& vehicle) {
        return vehicle.id >= scenario.population();
      }));
  return report;
}

}  // namespace

Result<CheckedScenario> CheckScenario(const Config& config, const std::filesystem::path& directory) {
  DADRL_ASSIGN_OR_RETURN(Scenario scenario, LoadScenario(config.scenario, directory));
  ScenarioCost cost;
  const TimePoint begin = SystemClock().Now();
  DADRL_ASSIGN_OR_RETURN(std::unique_ptr<DrivingEnvironment> environment,
                         DrivingEnvironment::Create(config, {.scenarios = directory}));
  cost.load_s = SecondsSince(begin);
  const Result<uint64_t> seed = StartEpisode(*environment, cost);
  if (!seed) {
    return Fail(seed.error().code, "{}: {}", scenario.file.string(), seed.error().message);
  }
  ScenarioReport report = MakeReport(*environment, scenario);
  DADRL_RETURN_IF_ERROR(MeasureSteps(*environment, cost));
  report.cost = cost;
  report.warnings = WarningsOf(report);
  return CheckedScenario{std::move(scenario), std::move(environment), *seed, std::move(report)};
}

}  // namespace dadrl
