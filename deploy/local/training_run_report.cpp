// How a TrainingRun ended, and what it tells of itself on the way.
#include <utility>

#include "deploy/local/cluster_processes.h"
#include "deploy/local/training_run.h"
#include "deploy/monitor/bottleneck.h"
#include "deploy/monitor/merge_supervision.h"

namespace dadrl {
namespace {

constexpr Duration kEpisodesInterval = std::chrono::seconds(1);

// In results.json.
const char* StateName(RunOutcome outcome) {
  switch (outcome) {
    case RunOutcome::kFinished:
      return "finished";
    case RunOutcome::kInterrupted:
      return "interrupted";
    case RunOutcome::kHeldUp:
      return "held_up";
    case RunOutcome::kFailed:
      break;
  }
  return "failed";
}

}  // namespace

bool TrainingRun::HeldUp() const {
  const auto wanted = static_cast<uint64_t>(config_.learner.max_updates);
  if (wanted > 0 && supervisor_.Work(kLearnerRole) >= wanted) return false;
  const double budget = config_.learner.max_cpu_seconds;
  if (budget > 0.0 && LastOfTraining(paths_.training()).cpu_s >= budget) return false;
  return health_.lost().HeldUp(FromSeconds(trained_s_));
}

void TrainingRun::EndRun(RunOutcome outcome) {
  const bool drained = outcome == RunOutcome::kFinished || outcome == RunOutcome::kInterrupted;
  outcome_ = drained && HeldUp() ? RunOutcome::kHeldUp : outcome;
  phase_ = Phase::kDone;
  evaluator_.Cancel();
  if (const std::string faults = fault_history_.Summary(); !faults.empty()) {
    display_.Message("faults of this session: " + faults);
  }
  if (const std::string lost = health_.lost().Sentence(FromSeconds(trained_s_)); !lost.empty()) {
    display_.Message(outcome_ == RunOutcome::kHeldUp ? lost + "; the training has not done its work" : lost);
  }
  SaveResults(StateName(outcome_));
  if (const Status saved = results_writer_.Finish(); !saved) {
    display_.Message(saved.error().message);
    outcome_ = RunOutcome::kFailed;
  }
}

void TrainingRun::SaveResults(const char* state) {
  UpdateEpisodes();
  results_.Update(state, phase_ == Phase::kTraining ? SessionSeconds() : trained_s_,
                  LastOfTraining(paths_.training()), *episodes_);
  results_.SetLost(health_.lost());
  results_writer_.Write(results_.Text());
}

void TrainingRun::UpdateEpisodes() {
  next_episodes_ = clock_.Now() + kEpisodesInterval;
  faults_.Report(FaultKind::kEpisodeLog, episodes_->Update());
}

double TrainingRun::SessionSeconds() const { return ToSeconds(clock_.Now() - started_); }

std::string TrainingRun::PhaseText(const ClusterSummary& summary) const {
  switch (phase_) {
    case Phase::kDrainingActors:
    case Phase::kDrainingLearner:
    case Phase::kDrainingReplay:
      return "stopping";
    case Phase::kFinalEvaluation:
      return evaluator_.Progress();
    default:
      break;
  }
  const bool evaluating = evaluator_.running();
  if (!monitor_) return evaluating ? "running and evaluating" : "running";
  if (summary.updates_per_s > 0.0) return evaluating ? "training and evaluating" : "training";
  const double needed = config_.replay.min_size;
  if (summary.replay_frames < needed) {
    return fmt::format("waiting for {} frames before training: {} so far", Thousands(needed),
                       Thousands(summary.replay_frames));
  }
  return "waiting for the learner";
}

Progress TrainingRun::MakeProgress() const {
  Progress progress;
  progress.summary = Summarize();
  progress.summary.episodes += earlier_episodes_;
  progress.summary.env_steps += earlier_env_steps_;
  progress.title = fmt::format("dadrl train {}  ({})", config_.scenario, paths_.root.string());
  progress.phase = PhaseText(progress.summary);
  progress.elapsed_s = results_.earlier_s() + (phase_ == Phase::kTraining ? SessionSeconds() : trained_s_);
  progress.total_s = 60.0 * config_.minutes;
  progress.last_evaluation = last_evaluation_;
  MergeSupervision(health_.supervision(), progress.summary);
  progress.faults = health_.supervision().Troubles();
  progress.bottleneck = !health_.fault().empty() ? health_.fault()
                        : monitor_               ? DescribeBottleneck(progress.summary, config_)
                                                 : "unknown without telemetry";
  return progress;
}

}  // namespace dadrl
