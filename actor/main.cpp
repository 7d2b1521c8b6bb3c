// dadrl-actor: drives the ego in simulation, to collect experience or to evaluate a policy; `dadrl-actor
// scenario ...`: what users do with scenarios (scenario_command.h).
#include <CLI/CLI.hpp>
#include <optional>
#include <string_view>

#include "actor/collect/collect_command.h"
#include "actor/evaluation/evaluation.h"
#include "actor/render/render_command.h"
#include "actor/scenario_command.h"
#include "common/config/config_yaml.h"
#include "common/liveness/stack_dump.h"
#include "common/util/log.h"
#include "common/util/process_setup.h"
#include "common/util/shutdown.h"
#include "proto/evaluation/seed_range.h"

namespace dadrl {
namespace {

constexpr int kMaxHoldSteps = 1000;

struct CollectArguments {
  std::string config;
  std::string run_directory;
  int index = 0;
  bool any_number = false;
  std::string host;
  int port = 0;
};

struct EvaluateArguments {
  std::string policy;
  std::string scenario;
  std::string seeds;
  std::string config;
  std::optional<int> hold_steps;
  std::optional<double> impatience;
};

struct RenderArguments {
  std::string policy;
  std::string scenario;
  std::optional<uint64_t> seed;
  std::string seeds;
  std::string config;
  std::string outcome;
  RenderOptions options;
};

CLI::App* AddCollect(CLI::App& app, CollectArguments& arguments) {
  CLI::App* command = app.add_subcommand("collect", "drive and send experience to the replay until stopped");
  command->add_option("--config", arguments.config, "configuration of the run")->required();
  command->add_option("--run-dir", arguments.run_directory, "directory of the run")->required();
  command->add_option("--index", arguments.index, "number of this actor, unique in the run")
      ->required()
      ->check(CLI::Range(0, 1'000'000));
  command->add_flag("--any-number", arguments.any_number,
                    "the run gives it a number; --index stands only in the names of its files");
  command->add_option("--host", arguments.host, "instead of cluster.host");
  command->add_option("--port", arguments.port, "instead of cluster.port")->check(CLI::Range(1, 65535));
  return command;
}

CLI::App* AddEvaluate(CLI::App& app, EvaluateArguments& arguments) {
  CLI::App* command = app.add_subcommand("evaluate", "drive episodes with a policy, print a line for each");
  command->add_option("--policy", arguments.policy, "policy file, or a scripted driver's name")->required();
  command->add_option("--seeds", arguments.seeds, "traffic seeds, FIRST:COUNT")->required();
  command->add_option("--scenario", arguments.scenario, "instead of the configuration's");
  command->add_option("--config", arguments.config, "configuration; defaults without");
  command->add_option("--hold", arguments.hold_steps, "of random: simulation steps an action is held")
      ->check(CLI::Range(1, kMaxHoldSteps));
  command->add_option("--impatience", arguments.impatience, "of idm: 0 yields, 1 takes the right of way")
      ->check(CLI::Range(0.0, 1.0));
  return command;
}

CLI::App* AddRender(CLI::App& app, RenderArguments& arguments) {
  CLI::App* command = app.add_subcommand("render", "drive episodes and draw them, print a line for each");
  RenderOptions& options = arguments.options;
  command->add_option("--policy", arguments.policy, "policy file, or a scripted driver's name")->required();
  command->add_option("--out", options.out, "ends in .svg, .png or /")->required();
  auto* seed = command->add_option("--seed", arguments.seed, "traffic seed");
  command->add_option("--seeds", arguments.seeds, "traffic seeds, FIRST:COUNT")->excludes(seed);
  command->add_option("--scenario", arguments.scenario, "instead of the configuration's");
  command->add_option("--config", arguments.config, "configuration; defaults without");
  command->add_option("--outcome", arguments.outcome, "draw only episodes that end so");
  command->add_option("--every", options.every, "simulation steps between moments");
  command->add_option("--moments", options.moments, "in a strip");
  command->add_option("--from", options.from_s, "seconds");
  command->add_option("--to", options.to_s, "seconds");
  return command;
}

Result<int> Collect(const CollectArguments& arguments) {
  CollectOptions options;
  DADRL_RETURN_IF_ERROR(LoadYaml(arguments.config, options.config));
  if (!arguments.host.empty()) options.config.cluster.host = arguments.host;
  if (arguments.port != 0) options.config.cluster.port = arguments.port;
  options.run_directory = arguments.run_directory;
  options.index = arguments.index;
  options.any_number = arguments.any_number;
  return RunCollect(options);
}

// Of an evaluation.
Result<std::vector<PlannedEpisode>> PlanSeeds(const std::string& text) {
  DADRL_ASSIGN_OR_RETURN(const SeedRange range, ParseSeedRange(text));
  if (range.first < kFirstEvaluationSeed) {
    return Fail(ErrorCode::kInvalidArgument,
                "--seeds: {} belongs to training; evaluation takes seeds from {} up", range.first,
                kFirstEvaluationSeed);
  }
  std::vector<PlannedEpisode> episodes;
  episodes.reserve(static_cast<size_t>(range.count));
  for (int i = 0; i < range.count; ++i) episodes.push_back({.seed = range.first + static_cast<uint64_t>(i)});
  return episodes;
}

Result<PolicyOptions> ParsePolicyOptions(const EvaluateArguments& arguments) {
  PolicyOptions options;
  const auto check = [&](const char* option, const char* policy) -> Status {
    if (arguments.policy == policy) return {};
    return Fail(ErrorCode::kInvalidArgument, "{} is for --policy {}, not for {}", option, policy,
                arguments.policy);
  };
  if (arguments.hold_steps) {
    DADRL_RETURN_IF_ERROR(check("--hold", "random"));
    options.random_hold_steps = *arguments.hold_steps;
  }
  if (arguments.impatience) {
    DADRL_RETURN_IF_ERROR(check("--impatience", "idm"));
    options.impatience = *arguments.impatience;
  }
  return options;
}

Status Evaluate(const EvaluateArguments& arguments) {
  EvaluationOptions options;
  DADRL_ASSIGN_OR_RETURN(options.policy_options, ParsePolicyOptions(arguments));
  if (!arguments.config.empty()) DADRL_RETURN_IF_ERROR(LoadYaml(arguments.config, options.config));
  if (!arguments.scenario.empty()) options.config.scenario = arguments.scenario;
  DADRL_ASSIGN_OR_RETURN(options.episodes, PlanSeeds(arguments.seeds));
  options.policy = arguments.policy;
  options.on_episode = [](const EvaluatedEpisode& episode) {
    return PrintLine(EpisodeLine(episode)) && !shutdown_requested;
  };
  const auto report = RunEvaluation(options);
  if (!report) return tl::unexpected<Error>(report.error());
  return {};
}

Status Render(const RenderArguments& arguments) {
  RenderOptions options = arguments.options;
  if (!arguments.config.empty()) DADRL_RETURN_IF_ERROR(LoadYaml(arguments.config, options.config));
  if (!arguments.scenario.empty()) options.config.scenario = arguments.scenario;
  options.policy = arguments.policy;
  options.gallery = !arguments.seeds.empty();
  if (options.gallery) {
    DADRL_ASSIGN_OR_RETURN(const SeedRange range, ParseSeedRange(arguments.seeds));
    for (int i = 0; i < range.count; ++i) options.seeds.push_back(range.first + static_cast<uint64_t>(i));
  } else {
    options.seeds = {arguments.seed.value_or(kFirstEvaluationSeed)};
  }
  if (!arguments.outcome.empty()) {
    options.outcome = OutcomeFromName(arguments.outcome);
    if (!options.outcome) return Fail(ErrorCode::kInvalidArgument, "--outcome: no '{}'", arguments.outcome);
  }
  return RunRender(options, [](const RenderedEpisode& episode) {
    return PrintLine(RenderedLine(episode)) && !shutdown_requested;
  });
}

int Main(int argc, char** argv) {
  CLI::App app("dadrl-actor: drives the ego vehicle in SUMO");
  app.require_subcommand(1);
  CollectArguments collect;
  EvaluateArguments evaluate;
  CLI::App* const collect_command = AddCollect(app, collect);
  AddEvaluate(app, evaluate);
  RenderArguments render;
  CLI::App* const render_command = AddRender(app, render);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const bool collecting = collect_command->parsed();
  const bool rendering = render_command->parsed();
  InitLogging(collecting ? fmt::format("actor-{}", collect.index) : rendering ? "render" : "evaluation");
  InstallShutdownHandler();
  InstallStackDump();
  const auto run = [&]() -> Result<int> {
    if (collecting) return Collect(collect);
    DADRL_RETURN_IF_ERROR(rendering ? Render(render) : Evaluate(evaluate));
    return 0;
  };
  const Result<int> code = run();
  if (code) return *code;
  spdlog::error("{}", code.error().message);
  return ExitCode(code.error());
}

}  // namespace
}  // namespace dadrl

int main(int argc, char** argv) {
  dadrl::SetUpProcess();
  if (argc > 1 && std::string_view(argv[1]) == "scenario")
    return dadrl::RunScenarioCommand(argc - 1, argv + 1);
  return dadrl::Main(argc, argv);
}
