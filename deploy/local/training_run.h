// One `dadrl train`: a local cluster from its start to its last result.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/clock.h"
#include "common/util/fault.h"
#include "common/util/result.h"
#include "deploy/local/background_writer.h"
#include "deploy/local/episode_log.h"
#include "deploy/local/fault_history.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/run_health.h"
#include "deploy/local/run_results.h"
#include "deploy/local/signals.h"
#include "deploy/local/supervisor.h"
#include "deploy/local/training_evaluator.h"
#include "deploy/monitor/cluster_monitor.h"
#include "deploy/monitor/progress_display.h"

namespace dadrl {

// How a training ended.
enum class RunOutcome {
  kFinished,     // by minutes, learner.max_updates or learner.max_cpu_seconds; drained and evaluated
  kInterrupted,  // drained on the user's word; --resume goes on
  kHeldUp,       // drained, but faults took more than half of its time (LostTime); --resume goes on
  kFailed,       // a process could not be kept alive, or the user would not wait
};

// Supervises replay, learner and actors, shows progress, evaluates in between and at the end
// (TrainingEvaluator), drains in order: actors, then the learner (its checkpoint), then the replay. Not
// thread safe; lives on the main thread.
class TrainingRun {
 public:
  // Borrows `signals` and `display`; `config` is what was saved to the run directory.
  static Result<std::unique_ptr<TrainingRun>> Create(const RunPaths& paths, const Config& config, bool resume,
                                                     SignalWatcher& signals, ProgressDisplay& display);

  // Blocks until everything has ended. An error is one of starting; afterwards failures are an outcome.
  Result<RunOutcome> Run();

 private:
  enum class Phase { kTraining, kDrainingActors, kDrainingLearner, kDrainingReplay, kFinalEvaluation, kDone };

  TrainingRun(const RunPaths& paths, const Config& config, bool resume, SignalWatcher& signals,
              ProgressDisplay& display);
  Status OpenTelemetry();
  Status StartCluster();

  void WaitForEvents();
  std::vector<pid_t> ChildPids() const;
  void AddPause(Duration paused);
  void HandleSignals();
  void Advance();
  void AdvanceTraining();
  // Leaves kTraining towards `outcome`; `why` is shown.
  void BeginDrain(RunOutcome outcome, const std::string& why);
  void Drain(const char* role, Phase next, const std::string& awaited);
  void AdvanceEvaluation();
  // False, with a message, when it cannot.
  bool StartEvaluation(bool final);
  void FinishEvaluation(const Result<EvaluatedPolicy>& evaluated);
  void EndRun(RunOutcome outcome);
  void KillEverything();
  // Faults took so much of its time that it did not do its work.
  bool HeldUp() const;

  // The cluster as telemetry shows it, with the launcher's own faults.
  ClusterSummary Summarize() const;
  // Says what began or is over.
  void FollowFaults();
  Progress MakeProgress() const;
  std::string PhaseText(const ClusterSummary& summary) const;
  void SaveResults(const char* state);
  void UpdateEpisodes();
  double SessionSeconds() const;

  const RunPaths paths_;
  const Config config_;
  const bool resume_;
  SignalWatcher& signals_;
  ProgressDisplay& display_;
  SystemClock clock_;
  Supervisor supervisor_;
  FaultBoard faults_{clock_, FaultBoard::Logging::kOff};  // the launcher's own; the display speaks of them
  RunHealth health_;
  std::unique_ptr<ClusterMonitor> monitor_;  // empty without telemetry
  std::optional<EpisodeLog> episodes_;       // there after Create
  FaultHistory fault_history_;
  uint64_t earlier_episodes_ = 0;  // of earlier sessions
  uint64_t earlier_env_steps_ = 0;
  RunResults results_;
  BackgroundWriter results_writer_;
  TrainingEvaluator evaluator_;
  EvaluatedAt evaluated_at_;  // of the evaluation under way
  std::string last_evaluation_;

  Phase phase_ = Phase::kTraining;
  RunOutcome outcome_ = RunOutcome::kFinished;
  TimePoint started_{};
  double trained_s_ = 0.0;  // of this session, fixed when draining begins
  TimePoint next_evaluation_{};
  TimePoint next_save_{};
  TimePoint next_episodes_{};
  TimePoint next_look_{};  // at the faults
  bool stop_handled_ = false;
};

}  // namespace dadrl
