#include <cstdio>
#include <memory>
#include <optional>

#include "common/io/atomic_file.h"
#include "common/util/resources.h"
#include "deploy/cli/command.h"
#include "deploy/cli/driver.h"
#include "deploy/cli/run_to_end.h"
#include "deploy/local/evaluation_job.h"
#include "deploy/local/signals.h"

namespace dadrl {
namespace {

struct EvaluateOptions {
  DriverOptions driver;
  int episodes = 50;
  int groups = 5;
  uint64_t first_seed = kFirstEvaluationSeed;
  int processes = 0;  // 0: one a core
  std::optional<int> hold_steps;
  std::optional<double> impatience;
  bool json = false;
  std::string csv;
};

std::vector<std::string> PolicyArguments(const EvaluateOptions& options) {
  std::vector<std::string> arguments;
  if (options.hold_steps) arguments = {"--hold", fmt::format("{}", *options.hold_steps)};
  if (options.impatience) {
    arguments.insert(arguments.end(), {"--impatience", fmt::format("{}", *options.impatience)});
  }
  return arguments;
}

void Warn(const std::string& text) { fmt::print(stderr, "dadrl evaluate: {}\n", text); }

Result<int> RunEvaluate(const EvaluateOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  DADRL_ASSIGN_OR_RETURN(const Driver driver, options.driver.Resolve());
  DADRL_RETURN_IF_ERROR(RequireDrivable(driver.config, "evaluate", signals.get()));
  DADRL_ASSIGN_OR_RETURN(
      EvaluationJob job,
      EvaluationJob::Create({.program = driver.program,
                             .policy = driver.policy,
                             .policy_label = options.driver.policy,
                             .policy_arguments = PolicyArguments(options),
                             .scenario = driver.config.scenario,
                             .config = driver.shared.path(),
                             .first_seed = options.first_seed,
                             .groups = options.groups,
                             .episodes = options.episodes,
                             .processes = options.processes > 0 ? options.processes : UsableCores(),
                             .hang_limits = HangLimits::Of(driver.config.cluster),
                             .notice = Warn}));
  DADRL_RETURN_IF_ERROR(RunToEnd(job, *signals));
  DADRL_ASSIGN_OR_RETURN(const EvaluationReport report, job.TakeReport());
  if (!options.csv.empty()) {
    DADRL_RETURN_IF_ERROR(WriteFileAtomically(options.csv, std::string_view(ReportCsv(report))));
  }
  if (options.json) {
    fmt::print("{}\n", ReportJson(report));
  } else {
    fmt::print("{}", ReportTable(report));
  }
  return 0;
}

}  // namespace

Command MakeEvaluateCommand(CLI::App& dadrl) {
  auto options = std::make_shared<EvaluateOptions>();
  CLI::App* app =
      dadrl.add_subcommand("evaluate", "Drive unseen traffic with a policy and report how it went");
  options->driver.AddTo(*app,
                        "Name, or all: every episode in each (default: what the policy was trained on)");
  app->add_option("--episodes", options->episodes, "Of each seed group (default 50)")
      ->check(CLI::Range(1, 1000));
  app->add_option("--seeds", options->groups, "Seed groups (default 5)")->check(CLI::Range(1, 1000));
  app->add_option("--first-seed", options->first_seed,
                  "Traffic seeds are K + 1000 group + episode (default 1000000)")
      ->type_name("K");
  app->add_option("--processes", options->processes, "Default: one a core")->check(CLI::Range(1, 1024));
  app->add_option("--hold", options->hold_steps, "Of random: simulation steps an action is held (default 10)")
      ->check(CLI::Range(1, 1000));
  app->add_option("--impatience", options->impatience,
                  "Of idm: 0 waits for a gap, 1 takes the right of way (default 1)")
      ->check(CLI::Range(0.0, 1.0));
  app->add_flag("--json", options->json, "One JSON object on standard output");
  app->add_option("--csv", options->csv, "Also write a row an episode to this file")->type_name("FILE");
  options->driver.config.AddTo(*app);
  return {app, [options] { return RunEvaluate(*options); }};
}

}  // namespace dadrl
