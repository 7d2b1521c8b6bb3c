#include <algorithm>
#include <cstdio>
#include <limits>
#include <memory>
#include <optional>

#include "common/util/resources.h"
#include "deploy/cli/command.h"
#include "deploy/cli/run_to_end.h"
#include "deploy/local/executables.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/selection_job.h"

namespace dadrl {
namespace {

struct SelectOptions {
  std::string run_dir = "runs/latest";
  std::optional<int> episodes;
  int candidates = std::numeric_limits<int>::max();
  int processes = UsableCores();
  bool json = false;
};

void Warn(const std::string& text) { fmt::print(stderr, "dadrl select: {}\n", text); }

Result<int> RunSelect(const SelectOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  // Held to the end: a training that went on would remove candidates.
  DADRL_ASSIGN_OR_RETURN(const RunDirectory run, RunDirectory::OpenExisting(options.run_dir));
  const RunPaths& paths = run.paths();
  Config config;
  DADRL_RETURN_IF_ERROR(LoadRunConfig(paths, config));
  DADRL_ASSIGN_OR_RETURN(std::vector<SavedPolicy> candidates,
                         NewestPolicies(paths, options.candidates, Warn));
  DADRL_ASSIGN_OR_RETURN(const std::filesystem::path program, FindExecutable("dadrl-actor"));
  DADRL_ASSIGN_OR_RETURN(
      SelectionJob job,
      SelectionJob::Create({.program = program,
                            .scenario = config.scenario,
                            .config = paths.config(),
                            .episodes = options.episodes.value_or(config.evaluation.candidate_episodes),
                            .processes = options.processes,
                            .hang_limits = HangLimits::Of(config.cluster),
                            .notice = Warn,
                            .candidates = std::move(candidates)}));
  DADRL_RETURN_IF_ERROR(RunToEnd(job, *signals));
  DADRL_ASSIGN_OR_RETURN(const Selection selection, job.TakeSelection());
  DADRL_RETURN_IF_ERROR(SaveSelection(paths, selection));
  if (options.json) {
    fmt::print("{}\n", SelectionJson(selection));
  } else {
    fmt::print("{}policy: {}\nrecord: {}\n", SelectionTable(selection), paths.best_policy().string(),
               paths.selection().string());
  }
  return 0;
}

}  // namespace

Command MakeSelectCommand(CLI::App& dadrl) {
  auto options = std::make_shared<SelectOptions>();
  CLI::App* app = dadrl.add_subcommand(
      "select",
      "Choose the best of a run's last policies, on traffic kept for that (train does so at its end)");
  app->add_option("--run-dir", options->run_dir, "Which run (default: runs/latest)")->type_name("DIR");
  app->add_option("--candidates", options->candidates, "The newest so many (default: all that the run kept)")
      ->check(CLI::Range(1, 1000));
  app->add_option("--episodes", options->episodes,
                  "Of each candidate, of each scenario, the same for all (default: the run's "
                  "evaluation.candidate_episodes)")
      ->check(CLI::Range(1, 1000));
  app->add_option("--processes", options->processes, "Default: one a core")->check(CLI::Range(1, 1024));
  app->add_flag("--json", options->json, "One JSON object on standard output");
  app->footer(
      "The highest success wins; among equals the fewest collisions, then the newest.\n"
      "RUN/checkpoints/best links to the choice, RUN/selection.json says how it came about.\n"
      "Traffic seeds start at 2000000: never those of training (below 1000000) or of dadrl evaluate.");
  return {app, [options] { return RunSelect(*options); }};
}

}  // namespace dadrl
