// dadrl-actor: drives the ego in simulation, to collect experience or to evaluate a policy.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <optional>

#include "actor/collect/collect_command.h"
#include "actor/evaluation/evaluation.h"
#include "common/config/config_yaml.h"
#include "common/util/log.h"
#include "common/util/shutdown.h"

namespace dadrl {
namespace {

constexpr int kMaxEpisodes = 1'000'000;
constexpr int kMaxHoldSteps = 1000;

struct CollectArguments {
  std::string config;
  std::string run_directory;
  int index = 0;
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

CLI::App* AddCollect(CLI::App& app, CollectArguments& arguments) {
  CLI::App* command = app.add_subcommand("collect", "drive and send experience to the replay until stopped");
  command->add_option("--config", arguments.config, "configuration of the run")->required();
  command->add_option("--run-dir", arguments.run_directory, "directory of the run")->required();
  command->add_option("--index", arguments.index, "number of this actor, unique in the run")
      ->required()
      ->check(CLI::Range(0, 1'000'000));
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

Status Collect(const CollectArguments& arguments) {
  CollectOptions options;
  DADRL_RETURN_IF_ERROR(LoadYaml(arguments.config, options.config));
  if (!arguments.host.empty()) options.config.cluster.host = arguments.host;
  if (arguments.port != 0) options.config.cluster.port = arguments.port;
  options.run_directory = arguments.run_directory;
  options.index = arguments.index;
  return RunCollect(options);
}

// "1000000:50"
Result<std::vector<PlannedEpisode>> ParseSeeds(const std::string& text) {
  unsigned long long first = 0;
  int count = 0;
  int used = 0;
  if (std::sscanf(text.c_str(), "%llu:%d%n", &first, &count, &used) != 2 ||
      used != static_cast<int>(text.size()) || count < 1 || count > kMaxEpisodes) {
    return Fail(ErrorCode::kInvalidArgument, "--seeds: '{}' is not FIRST:COUNT with a COUNT of 1 to {}", text,
                kMaxEpisodes);
  }
  if (first < kFirstEvaluationSeed) {
    return Fail(ErrorCode::kInvalidArgument,
                "--seeds: {} belongs to training; evaluation takes seeds from {} up", first,
                kFirstEvaluationSeed);
  }
  std::vector<PlannedEpisode> episodes;
  episodes.reserve(static_cast<size_t>(count));
  for (int i = 0; i < count; ++i) episodes.push_back({.seed = first + static_cast<uint64_t>(i)});
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
  DADRL_ASSIGN_OR_RETURN(options.episodes, ParseSeeds(arguments.seeds));
  options.policy = arguments.policy;
  options.on_episode = [](const EvaluatedEpisode& episode) {
    return PrintEpisodeLine(episode) && !shutdown_requested;
  };
  const auto report = RunEvaluation(options);
  if (!report) return tl::unexpected<Error>(report.error());
  return {};
}

int Main(int argc, char** argv) {
  CLI::App app("dadrl-actor: drives the ego vehicle in SUMO");
  app.require_subcommand(1);
  CollectArguments collect;
  EvaluateArguments evaluate;
  CLI::App* const collect_command = AddCollect(app, collect);
  AddEvaluate(app, evaluate);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  const bool collecting = collect_command->parsed();
  InitLogging(collecting ? fmt::format("actor-{}", collect.index) : "evaluation");
  InstallShutdownHandler();
  const Status status = collecting ? Collect(collect) : Evaluate(evaluate);
  if (status) return 0;
  spdlog::error("{}", status.error().message);
  return ExitCode(status.error());
}

}  // namespace
}  // namespace dadrl

int main(int argc, char** argv) { return dadrl::Main(argc, argv); }
