#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <memory>
#include <optional>
#include <utility>

#include "common/config/validate.h"
#include "common/io/run_key.h"
#include "deploy/cli/command.h"
#include "deploy/cli/driver.h"
#include "deploy/local/cluster_address.h"
#include "deploy/local/cluster_port.h"
#include "deploy/local/executables.h"
#include "deploy/local/experience_copy.h"
#include "deploy/local/resume_rules.h"
#include "deploy/local/training_run.h"
#include "deploy/monitor/bottleneck.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

struct TrainOptions {
  std::string scenario;
  ConfigOptions config;
  std::optional<int> actors;
  std::optional<double> minutes;
  std::optional<uint64_t> seed;
  bool resume = false;
  bool deterministic = false;
  std::string run_dir;
  std::string experience;

  fs::path ResumedDirectory() const { return run_dir.empty() ? fs::path("runs/latest") : fs::path(run_dir); }
};

// The dedicated options as if they were --set: one place for ranges and messages.
ConfigOptions WithShortOptions(const TrainOptions& options) {
  ConfigOptions config = options.config;
  if (!options.scenario.empty()) config.sets.push_back("scenario=" + options.scenario);
  if (options.actors) config.sets.push_back(fmt::format("actor.count={}", *options.actors));
  if (options.minutes) config.sets.push_back(fmt::format("minutes={}", *options.minutes));
  if (options.seed) config.sets.push_back(fmt::format("seed={}", *options.seed));
  return config;
}

// What the run shall do; for a resumed one, `saved` is what it did so far.
Result<Config> EffectiveConfig(const TrainOptions& options, const std::optional<Config>& saved) {
  const ConfigOptions given = WithShortOptions(options);
  DADRL_ASSIGN_OR_RETURN(Config config, saved ? given.Apply(*saved) : given.ApplyToPreset());
  if (saved) DADRL_RETURN_IF_ERROR(CheckResumable(*saved, config));
  DADRL_RETURN_IF_ERROR(CheckScenario(config.scenario));
  DADRL_RETURN_IF_ERROR(Validate(config));
  return config;
}

void PrintSummary(const RunPaths& paths, RunOutcome outcome) {
  fmt::print("run:     {}\nresults: {}\n", paths.root.string(), paths.results().string());
  std::error_code error;
  const fs::path policy = fs::exists(paths.best_policy(), error) ? paths.best_policy() : paths.policy();
  if (fs::exists(policy, error)) fmt::print("policy:  {}\n", policy.string());
  if (outcome != RunOutcome::kFinished) {
    fmt::print("go on:   dadrl train --resume --run-dir {}\n", paths.root.string());
  }
}

fs::path NewRunRoot(const TrainOptions& options, const Config& config) {
  return options.run_dir.empty() ? NewRunPath("runs", config.scenario) : fs::path(options.run_dir);
}

// Becomes dadrl-lockstep; returns only when it cannot.
Result<int> RunInLockstep(const TrainOptions& options) {
  if (options.resume) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "--deterministic with --resume: a lockstep training runs in one piece; leave one of them out");
  }
  if (!options.experience.empty()) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "--deterministic with --experience: a lockstep training begins with an empty replay; leave one "
        "of them out");
  }
  DADRL_ASSIGN_OR_RETURN(const Config config, EffectiveConfig(options, std::nullopt));
  DADRL_RETURN_IF_ERROR(RequireDrivable(config, "train", nullptr));
  DADRL_ASSIGN_OR_RETURN(const fs::path program, FindExecutable("dadrl-lockstep"));
  DADRL_ASSIGN_OR_RETURN(const RunDirectory directory, RunDirectory::CreateNew(NewRunRoot(options, config)));
  DADRL_RETURN_IF_ERROR(directory.SaveConfig(config));
  if (options.run_dir.empty()) LinkLatest(directory.paths().root);
  directory.KeepAcrossExec();
  const std::string config_file = directory.paths().config().string();
  const std::string root = directory.paths().root.string();
  execl(program.c_str(), program.c_str(), "--config", config_file.c_str(), "--run-dir", root.c_str(),
        static_cast<char*>(nullptr));
  return Fail(ErrorCode::kInternal, "cannot start {}: {}", program.string(), std::strerror(errno));
}

Result<int> RunTrain(const TrainOptions& options) {
  if (options.scenario.empty() && !options.resume) {
    return Fail(ErrorCode::kInvalidArgument, "which scenario? There are: {}, all",
                fmt::join(ScenarioNames(), ", "));
  }
  if (options.deterministic) return RunInLockstep(options);
  // Before any thread starts: they inherit the signal mask.
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());

  std::optional<RunDirectory> directory;
  std::optional<Config> saved;
  if (options.resume) {
    DADRL_ASSIGN_OR_RETURN(directory, RunDirectory::OpenExisting(options.ResumedDirectory()));
    DADRL_RETURN_IF_ERROR(LoadRunConfig(directory->paths(), saved.emplace()));
  }
  DADRL_ASSIGN_OR_RETURN(Config config, EffectiveConfig(options, saved));
  DADRL_RETURN_IF_ERROR(RequireDrivable(config, "train", signals.get()));
  DADRL_ASSIGN_OR_RETURN(config.cluster.host, ClusterAddress(config.cluster.host));
  DADRL_ASSIGN_OR_RETURN(config.cluster.port, ChoosePort(config, saved));
  if (!directory) {
    DADRL_ASSIGN_OR_RETURN(directory, RunDirectory::CreateNew(NewRunRoot(options, config)));
    if (!options.experience.empty()) {
      DADRL_RETURN_IF_ERROR(CopyExperience(options.experience, directory->paths(), config));
    }
  }
  DADRL_RETURN_IF_ERROR(directory->SaveConfig(config));
  DADRL_RETURN_IF_ERROR(EnsureRunKey(directory->paths().root));
  if (options.run_dir.empty() && !options.resume) LinkLatest(directory->paths().root);

  const SystemClock clock;
  ProgressDisplay display(stdout, clock);
  DADRL_ASSIGN_OR_RETURN(const auto run,
                         TrainingRun::Create(directory->paths(), config, options.resume, *signals, display));
  DADRL_ASSIGN_OR_RETURN(const RunOutcome outcome, run->Run());
  display.Finish();
  PrintSummary(directory->paths(), outcome);
  return outcome == RunOutcome::kFailed || outcome == RunOutcome::kHeldUp ? 1 : 0;
}

}  // namespace

Command MakeTrainCommand(CLI::App& dadrl) {
  auto options = std::make_shared<TrainOptions>();  // lives as long as the parser's references to it
  CLI::App* app = dadrl.add_subcommand("train", "Train on a local cluster: replay, learner, actors");
  app->add_option("scenario", options->scenario,
                  "What to learn: " + fmt::format("{}", fmt::join(ScenarioNames(), ", ")) +
                      "; or all: one policy for them all");
  app->add_option("--actors", options->actors, "Actor processes (actor.count)");
  app->add_option("--minutes", options->minutes, "Minutes of training; 0 is until stopped (minutes)");
  app->add_option("--seed", options->seed, "Of everything random (seed)");
  app->add_flag("--resume", options->resume, "Go on with the run in --run-dir (default: runs/latest)");
  app->add_flag("--deterministic", options->deterministic,
                "One process, all roles in turns: same seed, same weights (a minute is 1,200 updates)");
  app->add_option(
         "--experience", options->experience,
         "Begin with a copy of what this collection (dadrl collect) or run has stored; with --actors "
         "0 that is all there is to learn from")
      ->type_name("DIR")
      ->excludes("--resume");
  app->add_option("--run-dir", options->run_dir, "Where the run lives (default: runs/SCENARIO-TIME)")
      ->type_name("DIR");
  options->config.AddTo(*app);
  app->footer(
      "At the end the best of the last evaluation.candidates policies is chosen on traffic kept for that, "
      "and\n"
      "evaluated: RUN/checkpoints/best (dadrl select --help).\n"
      "Recipes of the policies that ship: --config deploy/config/scenarios/SCENARIO.yaml");
  return {app, [options] { return RunTrain(*options); }};
}

}  // namespace dadrl
