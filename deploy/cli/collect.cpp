#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/io/run_key.h"
#include "common/model/policy_file.h"
#include "deploy/cli/command.h"
#include "deploy/cli/driver.h"
#include "deploy/local/cluster_address.h"
#include "deploy/local/cluster_port.h"
#include "deploy/local/collection_run.h"
#include "deploy/local/executables.h"
#include "deploy/local/resume_rules.h"
#include "deploy/local/shipped_policies.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

struct CollectOptions {
  std::string scenario;
  std::string policy;
  ConfigOptions config;
  std::optional<int> actors;
  std::optional<uint64_t> seed;
  CollectionGoal goal;
  bool only_successes = false;
  bool resume = false;
  bool json = false;
  std::string out;
};

// Without throwing where standard error is gone, as fmt::print would.
void Say(const std::string& text) { std::fputs((text + "\n").c_str(), stderr); }

Result<ConfigOptions> WithShortOptions(const CollectOptions& options) {
  ConfigOptions config = options.config;
  if (!options.scenario.empty()) config.sets.push_back("scenario=" + options.scenario);
  if (!options.policy.empty()) {
    DADRL_ASSIGN_OR_RETURN(std::string policy, ResolvePolicy(options.policy));
    // Its actors work elsewhere.
    if (policy.find_first_of("/.") != std::string::npos) policy = fs::absolute(policy).string();
    config.sets.push_back("actor.policy=" + policy);
  }
  if (options.actors) config.sets.push_back(fmt::format("actor.count={}", *options.actors));
  if (options.seed) config.sets.push_back(fmt::format("seed={}", *options.seed));
  if (options.only_successes) config.sets.emplace_back("actor.keep=successes");
  return config;
}

// A learned driver sees what it was trained on, and decides as often.
Status SuitDriver(Config& config) {
  const std::string& policy = config.actor.policy;
  if (policy == "learned") {
    return Fail(ErrorCode::kInvalidArgument,
                "--policy: there is no learner; name a policy file or one of: random, rdm, slow, predictive");
  }
  if (policy.find_first_of("/.") == std::string::npos) return {};
  DADRL_ASSIGN_OR_RETURN(const PolicyFile file, LoadPolicy(policy));
  config.observation = file.config.observation;
  config.task.decision_interval = file.config.task.decision_interval;
  config.task.max_speed_mps = file.config.task.max_speed_mps;
  return {};
}

Result<Config> EffectiveConfig(const CollectOptions& options, const std::optional<Config>& saved) {
  DADRL_ASSIGN_OR_RETURN(const ConfigOptions given, WithShortOptions(options));
  DADRL_ASSIGN_OR_RETURN(Config config, saved ? given.Apply(*saved) : given.ApplyToPreset());
  DADRL_RETURN_IF_ERROR(CheckScenario(config.scenario));
  DADRL_RETURN_IF_ERROR(Validate(config));
  DADRL_RETURN_IF_ERROR(SuitDriver(config));
  if (saved) DADRL_RETURN_IF_ERROR(CheckResumable(*saved, config));
  return config;
}

Status CheckOptions(const CollectOptions& options) {
  if (options.goal.episodes == 0 && options.goal.successes == 0) {
    return Fail(ErrorCode::kInvalidArgument, "how much? Give --episodes N or --successes N");
  }
  if (options.resume) return {};
  if (options.scenario.empty()) {
    return Fail(ErrorCode::kInvalidArgument, "which scenario? There are: {}, all",
                fmt::join(ScenarioNames(), ", "));
  }
  if (options.policy.empty()) {
    return Fail(ErrorCode::kInvalidArgument,
                "who drives? Give --policy: random, rdm, slow, predictive or a policy file");
  }
  return {};
}

void PrintSummary(const CollectOptions& options, CollectionOutcome outcome, const StoredEpisodes& stored) {
  if (options.json) {
    const nlohmann::ordered_json json = {{"directory", options.out},
                                         {"finished", outcome == CollectionOutcome::kFinished},
                                         {"episodes", stored.episodes},
                                         {"successes", stored.successes},
                                         {"frames", stored.frames}};
    fmt::print("{}\n", json.dump());
  } else {
    fmt::print("{} episodes, {} of them successes, {} frames in {}\n", stored.episodes, stored.successes,
               stored.frames, options.out);
  }
  if (outcome == CollectionOutcome::kFinished) return;
  Say(fmt::format("go on:  dadrl collect --resume --out {} --episodes {} --successes {}", options.out,
                  options.goal.episodes, options.goal.successes));
}

Result<int> RunCollect(const CollectOptions& options) {
  DADRL_RETURN_IF_ERROR(CheckOptions(options));
  // Before any thread starts: they inherit the signal mask.
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  std::optional<RunDirectory> directory;
  std::optional<Config> saved;
  if (options.resume) {
    DADRL_ASSIGN_OR_RETURN(directory, RunDirectory::OpenExisting(options.out));
    DADRL_RETURN_IF_ERROR(LoadRunConfig(directory->paths(), saved.emplace()));
  }
  DADRL_ASSIGN_OR_RETURN(Config config, EffectiveConfig(options, saved));
  DADRL_RETURN_IF_ERROR(RequireDrivable(config, "collect", signals.get()));
  DADRL_ASSIGN_OR_RETURN(config.cluster.host, ClusterAddress(config.cluster.host));
  DADRL_ASSIGN_OR_RETURN(config.cluster.port, ChoosePort(config, saved));
  if (!directory) {
    DADRL_ASSIGN_OR_RETURN(directory, RunDirectory::CreateNew(options.out));
  }
  DADRL_RETURN_IF_ERROR(directory->SaveConfig(config));
  DADRL_RETURN_IF_ERROR(EnsureRunKey(directory->paths().root));
  DADRL_ASSIGN_OR_RETURN(const auto run,
                         CollectionRun::Create(directory->paths(), config, options.goal, *signals, Say));
  DADRL_ASSIGN_OR_RETURN(const CollectionOutcome outcome, run->Run());
  PrintSummary(options, outcome, run->stored());
  return outcome == CollectionOutcome::kFailed ? 1 : 0;
}

}  // namespace

Command MakeCollectCommand(CLI::App& dadrl) {
  auto options = std::make_shared<CollectOptions>();  // lives as long as the parser's references to it
  CLI::App* app = dadrl.add_subcommand("collect", "Store what a driver does: actors and replay, no learner");
  constexpr uint64_t kMost = 1'000'000'000;
  app->add_option("scenario", options->scenario, "Where to drive, or all");
  app->add_option("--policy", options->policy,
                  "Who drives: random, rdm, slow, predictive, a policy file or pretrained:NAME");
  app->add_option("--episodes", options->goal.episodes, "Ends when so many are stored")
      ->check(CLI::Range(uint64_t{1}, kMost));
  app->add_option("--successes", options->goal.successes,
                  "Ends when so many that reached the goal are stored")
      ->check(CLI::Range(uint64_t{1}, kMost));
  app->add_flag("--only-successes", options->only_successes, "Store no others (actor.keep)");
  app->add_option("--out", options->out, "Folder of the experience and its logs")
      ->required()
      ->type_name("DIR");
  app->add_flag("--resume", options->resume, "Add to what is in --out; what is there counts");
  app->add_option("--actors", options->actors, "Actor processes (actor.count)");
  app->add_option("--seed", options->seed, "Of everything random (seed)");
  app->add_flag("--json", options->json, "The summary as one JSON object on standard output");
  options->config.AddTo(*app);
  app->footer(
      "dadrl replay inspect | verify | export DIR read it; dadrl train SCENARIO --experience DIR learns from "
      "it:\n"
      "dadrl train left_turn --set algorithm.name=bc --experience DIR --actors 0 --set "
      "replay.samples_per_insert=0 --minutes 3");
  return {app, [options] { return RunCollect(*options); }};
}

}  // namespace dadrl
