#include "deploy/local/training_run.h"

#include <algorithm>
#include <thread>
#include <utility>

#include "common/dds/address.h"
#include "common/model/policy_file.h"
#include "deploy/local/cluster_processes.h"
#include "deploy/local/executables.h"
#include "deploy/monitor/bottleneck.h"

namespace dadrl {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(100);
constexpr Duration kSaveInterval = std::chrono::seconds(10);
// The learner stops by itself when `minutes` are over; this much later it is stopped.
constexpr double kOverrun_s = 30.0;
// While training the evaluation takes what the cluster leaves over.
constexpr int kEvaluationNice = 10;
// Seeds that choose between policies are not those that grade the last one.
constexpr uint64_t kValidationSeed = 2 * kFirstEvaluationSeed;

int Cores() { return std::max(1, static_cast<int>(std::thread::hardware_concurrency())); }

}  // namespace

TrainingRun::TrainingRun(const RunPaths& paths, const Config& config, bool resume, SignalWatcher& signals,
                         ProgressDisplay& display)
    : paths_(paths),
      config_(config),
      resume_(resume),
      signals_(signals),
      display_(display),
      supervisor_(RestartLimits{}, clock_, [this](const std::string& text) { display_.Message(text); }),
      results_(RunResults::Load(paths.results(), config)) {}

Result<std::unique_ptr<TrainingRun>> TrainingRun::Create(const RunPaths& paths, const Config& config,
                                                         bool resume, SignalWatcher& signals,
                                                         ProgressDisplay& display) {
  std::unique_ptr<TrainingRun> run(new TrainingRun(paths, config, resume, signals, display));
  DADRL_ASSIGN_OR_RETURN(run->episodes_, EpisodeLog::Open(paths.episodes()));
  run->OpenTelemetry();
  return run;
}

void TrainingRun::OpenTelemetry() {
  auto monitor = ClusterMonitor::Open(
      config_, clock_,
      {.on_status = [this](const ProcessStatus& status) { supervisor_.MarkReady(status.pid); },
       .on_episode =
           [this](const EpisodeReport& report) {
             const Status written = episodes_->Append(report);
             const bool failed_before = std::exchange(episode_lost_, !written);
             if (!written && !failed_before) display_.Message(written.error().message);
           }});
  if (monitor) {
    monitor_ = std::move(*monitor);
  } else {
    display_.Message("training without a progress display: " + monitor.error().message);
  }
}

Status TrainingRun::StartCluster() {
  DADRL_ASSIGN_OR_RETURN(std::vector<ProcessSpec> specs, ClusterProcesses(paths_, config_));
  for (ProcessSpec& spec : specs) DADRL_RETURN_IF_ERROR(supervisor_.Start(std::move(spec), resume_));
  return {};
}

Result<RunOutcome> TrainingRun::Run() {
  BecomeSubreaper();
  started_ = clock_.Now();
  next_evaluation_ = started_ + FromSeconds(config_.evaluation.interval_s);
  next_save_ = started_;
  DADRL_RETURN_IF_ERROR(StartCluster());
  display_.Message(fmt::format("{} run {}: {} replay, 1 learner, {} actors; Ctrl-C stops with a checkpoint",
                               resume_ ? "resumed" : "new", paths_.root.string(), config_.replay.shards,
                               config_.actor.count));
  if (!dds::IsLoopback(config_.cluster.host)) {
    display_.Message(fmt::format("other machines join with: dadrl actor --join {}:{}", config_.cluster.host,
                                 config_.cluster.port));
  }
  while (phase_ != Phase::kDone) {
    WaitForEvents();
    if (monitor_) monitor_->Poll(Duration::zero());
    supervisor_.Step();
    std::vector<pid_t> owned = supervisor_.RunningPids();
    if (evaluation_) {
      evaluation_->Step();
      const std::vector<pid_t> more = evaluation_->RunningPids();
      owned.insert(owned.end(), more.begin(), more.end());
    }
    ReapAdopted(owned);
    HandleStopRequests();
    Advance();
    if (phase_ != Phase::kDone && display_.Due()) display_.Show(MakeProgress());
  }
  return outcome_;
}

void TrainingRun::WaitForEvents() {
  std::vector<pollfd> fds = {{.fd = signals_.fd(), .events = POLLIN, .revents = 0}};
  supervisor_.AppendWaitFds(fds);
  if (evaluation_) evaluation_->AppendWaitFds(fds);
  const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(supervisor_.NextDeadline(kTick));
  poll(fds.data(), fds.size(), static_cast<int>(wait.count()));
}

void TrainingRun::HandleStopRequests() {
  if (signals_.KillRequested()) {
    KillEverything();
    return;
  }
  if (!signals_.StopRequested() || stop_handled_) return;
  stop_handled_ = true;
  if (phase_ == Phase::kTraining) {
    BeginDrain(RunOutcome::kInterrupted, "stopping; once more Ctrl-C kills without a checkpoint");
  } else if (phase_ == Phase::kFinalEvaluation) {
    display_.Message("the final evaluation is cut short");
    EndRun(RunOutcome::kInterrupted);
  } else {
    // Draining already: only the final evaluation is left out.
    if (outcome_ == RunOutcome::kFinished) outcome_ = RunOutcome::kInterrupted;
  }
}

void TrainingRun::Advance() {
  switch (phase_) {
    case Phase::kTraining:
      AdvanceTraining();
      break;
    case Phase::kDrainingActors:
      Drain(kActorRole, Phase::kDrainingLearner, "the actors to finish their step");
      break;
    case Phase::kDrainingLearner:
      Drain(kLearnerRole, Phase::kDrainingReplay, "the learner's checkpoint");
      break;
    case Phase::kDrainingReplay:
      Drain(kReplayRole, Phase::kFinalEvaluation, "the replay to close its files");
      if (phase_ != Phase::kFinalEvaluation) break;
      if (outcome_ != RunOutcome::kFinished) {
        EndRun(outcome_);
      } else if (!StartEvaluation(true)) {
        display_.Message(fmt::format("there is no policy to evaluate in {}", paths_.checkpoints().string()));
        EndRun(RunOutcome::kFailed);
      }
      break;
    case Phase::kFinalEvaluation:
      AdvanceEvaluation();
      break;
    case Phase::kDone:
      break;
  }
}

void TrainingRun::AdvanceTraining() {
  if (supervisor_.Count(kLearnerRole, ProcessState::kFinished) > 0) {
    BeginDrain(RunOutcome::kFinished, "the learner has finished");
    return;
  }
  if (const auto lost = supervisor_.Lost()) {
    BeginDrain(RunOutcome::kFailed, "training cannot go on: " + *lost);
    return;
  }
  if (config_.minutes > 0.0 && SessionSeconds() > 60.0 * config_.minutes + kOverrun_s) {
    BeginDrain(RunOutcome::kFinished, fmt::format("{:g} minutes are over", config_.minutes));
    return;
  }
  AdvanceEvaluation();
  const bool due = config_.evaluation.interval_s > 0.0 && clock_.Now() >= next_evaluation_;
  std::error_code error;
  if (due && !evaluation_ && std::filesystem::exists(paths_.policy(), error)) {
    next_evaluation_ = clock_.Now() + FromSeconds(config_.evaluation.interval_s);
    StartEvaluation(false);
  }
  if (clock_.Now() >= next_save_) {
    next_save_ = clock_.Now() + kSaveInterval;
    SaveResults("running");
  }
}

void TrainingRun::BeginDrain(RunOutcome outcome, const std::string& why) {
  trained_s_ = SessionSeconds();
  outcome_ = outcome;
  phase_ = Phase::kDrainingActors;
  evaluation_.reset();
  display_.Message(why);
  Advance();
}

void TrainingRun::Drain(const char* role, Phase next, const std::string& awaited) {
  if (!supervisor_.RoleEnded(role)) {
    if (supervisor_.Count(role, ProcessState::kStopping) == 0) {
      supervisor_.StopRole(role);
      display_.Message("waiting for " + awaited);
    }
    return;
  }
  phase_ = next;
}

bool TrainingRun::StartEvaluation(bool final) {
  std::error_code error;
  std::filesystem::copy_file(paths_.policy(), paths_.evaluated_policy(),
                             std::filesystem::copy_options::overwrite_existing, error);
  if (error) return false;
  const auto policy = LoadPolicy(paths_.evaluated_policy());
  const auto program = FindExecutable("dadrl-actor");
  if (!policy || !program) {
    display_.Message(policy ? program.error().message : policy.error().message);
    return false;
  }
  const double driven = monitor_ ? monitor_->Summarize().env_steps : 0.0;
  evaluated_at_ = {.elapsed_s = results_.earlier_s() + (final ? trained_s_ : SessionSeconds()),
                   .env_steps = static_cast<uint64_t>(results_.earlier_env_steps() + driven),
                   .updates = policy->updates,
                   .policy_version = policy->policy_version};
  auto job = EvaluationJob::Create(
      {.program = *program,
       .policy = paths_.evaluated_policy(),
       .policy_label = fmt::format("{}@{}", paths_.root.filename().string(), policy->updates),
       .scenario = config_.scenario,
       .config = paths_.config(),
       .first_seed = final ? kFirstEvaluationSeed : kValidationSeed,
       .episodes = config_.evaluation.episodes,
       .processes = final ? std::max(Cores(), config_.evaluation.processes) : config_.evaluation.processes,
       .nice = final ? 0 : kEvaluationNice});
  if (!job) {
    display_.Message(job.error().message);
    return false;
  }
  evaluation_.emplace(std::move(*job));
  final_evaluation_ = final;
  return true;
}

void TrainingRun::AdvanceEvaluation() {
  if (evaluation_ && evaluation_->done()) FinishEvaluation();
}

void TrainingRun::FinishEvaluation() {
  const auto report = evaluation_->TakeReport();
  evaluation_.reset();
  if (!report) {
    display_.Message("evaluation: " + report.error().message);
    if (final_evaluation_) EndRun(RunOutcome::kFailed);
    return;
  }
  last_evaluation_ = fmt::format("{} updates: {}", Thousands(static_cast<double>(evaluated_at_.updates)),
                                 ReportLine(*report));
  display_.Message(
      fmt::format("{} after {}", final_evaluation_ ? "final evaluation" : "evaluation", last_evaluation_));
  if (final_evaluation_) {
    results_.SetFinal(evaluated_at_, *report);
    EndRun(RunOutcome::kFinished);
  } else {
    results_.AddEvaluation(evaluated_at_, *report);
    SaveResults("running");
  }
}

void TrainingRun::KillEverything() {
  display_.Message("killing everything; the last checkpoint stays");
  if (phase_ == Phase::kTraining) trained_s_ = SessionSeconds();
  evaluation_.reset();
  supervisor_.KillAll();
  EndRun(RunOutcome::kFailed);
}

void TrainingRun::EndRun(RunOutcome outcome) {
  outcome_ = outcome;
  phase_ = Phase::kDone;
  evaluation_.reset();
  SaveResults(outcome == RunOutcome::kFinished      ? "finished"
              : outcome == RunOutcome::kInterrupted ? "interrupted"
                                                    : "failed");
}

void TrainingRun::SaveResults(const char* state) {
  const ClusterSummary summary = monitor_ ? monitor_->Summarize() : ClusterSummary{};
  results_.Update(state, phase_ == Phase::kTraining ? SessionSeconds() : trained_s_, summary);
  const Status saved = results_.Save();
  if (!saved) display_.Message(saved.error().message);
}

double TrainingRun::SessionSeconds() const { return ToSeconds(clock_.Now() - started_); }

std::string TrainingRun::PhaseText(const ClusterSummary& summary) const {
  switch (phase_) {
    case Phase::kDrainingActors:
    case Phase::kDrainingLearner:
    case Phase::kDrainingReplay:
      return "stopping";
    case Phase::kFinalEvaluation:
      return evaluation_ ? fmt::format("final evaluation: {} of {} episodes",
                                       evaluation_->finished_episodes(), evaluation_->planned_episodes())
                         : "final evaluation";
    default:
      break;
  }
  if (!monitor_) return evaluation_ ? "running and evaluating" : "running";
  if (summary.updates_per_s > 0.0) return evaluation_ ? "training and evaluating" : "training";
  const auto needed = static_cast<double>(config_.replay.min_size);
  if (summary.replay_frames < needed) {
    return fmt::format("waiting for {} frames before training: {} so far", Thousands(needed),
                       Thousands(summary.replay_frames));
  }
  return "waiting for the learner";
}

Progress TrainingRun::MakeProgress() const {
  Progress progress;
  if (monitor_) progress.summary = monitor_->Summarize();
  progress.title = fmt::format("dadrl train {}  ({})", config_.scenario, paths_.root.string());
  progress.phase = PhaseText(progress.summary);
  progress.elapsed_s = results_.earlier_s() + (phase_ == Phase::kTraining ? SessionSeconds() : trained_s_);
  progress.total_s = 60.0 * config_.minutes;
  progress.last_evaluation = last_evaluation_;
  progress.bottleneck =
      monitor_ ? DescribeBottleneck(progress.summary, config_) : "unknown without telemetry";
  return progress;
}

}  // namespace dadrl
