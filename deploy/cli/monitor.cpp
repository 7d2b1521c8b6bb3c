#include <poll.h>

#include <algorithm>
#include <filesystem>
#include <memory>

#include "common/dds/cluster_key.h"
#include "common/io/link_file.h"
#include "deploy/cli/command.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/run_results.h"
#include "deploy/local/signals.h"
#include "deploy/monitor/bottleneck.h"
#include "deploy/monitor/cluster_monitor.h"
#include "deploy/monitor/merge_supervision.h"
#include "deploy/monitor/monitor_json.h"
#include "deploy/monitor/progress_display.h"
#include "deploy/monitor/supervision.h"

namespace dadrl {
namespace {

struct MonitorOptions {
  std::string run_dir = "runs/latest";
  bool json = false;
  bool once = false;
};

constexpr Duration kTick = std::chrono::milliseconds(50);

// Enough messages for rates: intervals of the status messages.
constexpr double kListenIntervals = 4.0;
// Without a word for so long, something is wrong.
constexpr double kPatience_s = 5.0;

// Listens until rates are known and no new process shows up; kUnavailable when nobody speaks.
Status Listen(ClusterMonitor& monitor, const Config& config, SignalWatcher& signals, const Clock& clock) {
  const TimePoint start = clock.Now();
  const double listen_s = kListenIntervals * config.telemetry.interval_s;
  const double patience_s = std::max(kPatience_s, listen_s + config.telemetry.interval_s);
  double waited_s = 0.0;
  while (!signals.StopRequested() && waited_s < patience_s) {
    monitor.Poll(kTick);
    if (signals.PauseRequested()) signals.PauseWith({});
    waited_s = ToSeconds(clock.Now() - start);
    if (monitor.ReportingProcesses() > 0 && waited_s >= listen_s) return {};
  }
  return Fail(
      ErrorCode::kUnavailable,
      "no telemetry heard in {:.0f} s: the run is starting, or this is another host or container than its "
      "replay's, which alone hears it: run the monitor there (dadrl doctor tells what it lacks)",
      waited_s);
}

// What the launcher says of its processes, and what the system does; nothing where there is no such word.
Supervision ReadSupervision(const RunPaths& paths) {
  Supervision supervision = LoadSupervision(paths.processes()).value_or(Supervision{});
  AddStopped(supervision);
  return supervision;
}

Progress MakeProgress(const RunPaths& paths, const Config& config, const ClusterMonitor& monitor) {
  const Supervision supervision = ReadSupervision(paths);
  Progress progress;
  progress.summary = monitor.Summarize();
  MergeSupervision(supervision, progress.summary);
  progress.faults = supervision.Troubles();
  progress.title = fmt::format("dadrl monitor {}  ({})", config.scenario, paths.root.string());
  progress.phase = progress.summary.updates_per_s > 0 ? "training" : "not training";
  for (const ProcessRow& row : progress.summary.processes) {
    progress.elapsed_s = std::max(progress.elapsed_s, row.uptime_s);
  }
  progress.last_evaluation = LastEvaluation(paths.results());
  progress.bottleneck = DescribeBottleneck(progress.summary, config);
  progress.show_processes = true;
  return progress;
}

void PrintOnce(const Progress& progress, const Config& config, bool json) {
  if (json) {
    auto object = MonitorJson(progress.summary, progress.bottleneck);
    object["scenario"] = config.scenario;
    object["troubles"] = progress.faults;
    fmt::print("{}\n", object.dump());
    return;
  }
  constexpr size_t kWide = 200;
  const TerminalSize all{.columns = std::min(kWide, SizeOf(stdout).columns)};
  for (const std::string& line : RenderPanel(progress, all)) fmt::print("{}\n", line);
}

Result<int> RunMonitor(const MonitorOptions& options) {
  const RunPaths paths{.root = FollowLinks(options.run_dir)};
  if (!std::filesystem::exists(paths.config())) {
    return Fail(ErrorCode::kNotFound, "{} holds no run (no config.yaml): name one with --run-dir",
                options.run_dir);
  }
  Config config;
  DADRL_RETURN_IF_ERROR(LoadRunConfig(paths, config));
  if (!IsRunning(paths)) {
    return Fail(ErrorCode::kUnavailable,
                "{} is not running: start it, or go on with it: dadrl train --resume --run-dir {}",
                options.run_dir, options.run_dir);
  }
  DADRL_ASSIGN_OR_RETURN(const std::unique_ptr<SignalWatcher> signals, SignalWatcher::Create());
  const SystemClock clock;
  DADRL_ASSIGN_OR_RETURN(const std::string key, dds::LoadClusterKey(paths.root, config.cluster));
  DADRL_ASSIGN_OR_RETURN(const auto monitor, ClusterMonitor::Open(config, key, clock));
  Status heard = Listen(*monitor, config, *signals, clock);
  // A silent cluster is what one would like to be told of.
  if (!heard && !ReadSupervision(paths).Troubles().empty()) heard = {};
  if (options.json || options.once) {
    DADRL_RETURN_IF_ERROR(heard);
    PrintOnce(MakeProgress(paths, config, *monitor), config, options.json);
    return 0;
  }
  ProgressDisplay display(stdout, clock);
  if (!heard && !signals->StopRequested()) display.Message(heard.error().message + "; still listening");
  while (!signals->StopRequested() && IsRunning(paths)) {
    monitor->Poll(kTick);
    if (signals->PauseRequested()) signals->PauseWith({});
    if (!display.Due()) continue;
    const Progress progress = MakeProgress(paths, config, *monitor);
    if (!progress.summary.processes.empty()) display.Show(progress);
  }
  return 0;
}

}  // namespace

Command MakeMonitorCommand(CLI::App& dadrl) {
  auto options = std::make_shared<MonitorOptions>();
  CLI::App* app = dadrl.add_subcommand("monitor", "Show what a running cluster does and who holds it up");
  app->add_option("--run-dir", options->run_dir, "Which run (default: runs/latest)")->type_name("DIR");
  app->add_flag("--json", options->json, "One JSON object, once");
  app->add_flag("--once", options->once, "Print once instead of until Ctrl-C");
  return {app, [options] { return RunMonitor(*options); }};
}

}  // namespace dadrl
