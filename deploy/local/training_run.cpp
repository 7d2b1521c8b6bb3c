#include "deploy/local/training_run.h"

#include <utility>

#include "common/dds/address.h"
#include "common/dds/cluster_key.h"
#include "common/io/atomic_file.h"
#include "deploy/local/cluster_processes.h"
#include "deploy/local/policy_selection.h"
#include "deploy/monitor/bottleneck.h"

namespace dadrl {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(100);
constexpr Duration kSaveInterval = std::chrono::seconds(10);
constexpr Duration kFaultInterval = std::chrono::milliseconds(500);
// The learner stops by itself when `minutes` are over; this much later it is stopped.
constexpr double kOverrun_s = 30.0;

}  // namespace

TrainingRun::TrainingRun(const RunPaths& paths, const Config& config, bool resume, SignalWatcher& signals,
                         ProgressDisplay& display)
    : paths_(paths),
      config_(config),
      resume_(resume),
      signals_(signals),
      display_(display),
      supervisor_(RestartLimits{}, HangLimits::Of(config.cluster), clock_,
                  [this](const std::string& text) { display_.Message(text); }),
      health_(paths.processes(), clock_, faults_),
      results_(RunResults::Load(paths.results(), config)),
      results_writer_([file = paths.results()](const std::string& text) {
        return WriteFileAtomically(file, std::string_view(text));
      }),
      evaluator_(paths, config, [this](const std::string& text) { display_.Message(text); }) {}

Result<std::unique_ptr<TrainingRun>> TrainingRun::Create(const RunPaths& paths, const Config& config,
                                                         bool resume, SignalWatcher& signals,
                                                         ProgressDisplay& display) {
  std::unique_ptr<TrainingRun> run(new TrainingRun(paths, config, resume, signals, display));
  DADRL_ASSIGN_OR_RETURN(run->episodes_, EpisodeLog::Open(paths.episodes(), paths.logs()));
  run->UpdateEpisodes();
  run->earlier_episodes_ = run->episodes_->episodes();
  run->earlier_env_steps_ = run->episodes_->env_steps();
  DADRL_RETURN_IF_ERROR(run->OpenTelemetry());
  return run;
}

Status TrainingRun::OpenTelemetry() {
  DADRL_ASSIGN_OR_RETURN(const std::string key, dds::LoadClusterKey(paths_.root, config_.cluster));
  auto monitor = ClusterMonitor::Open(config_, key, clock_);
  if (monitor) {
    monitor_ = std::move(*monitor);
  } else {
    display_.Message("training without a progress display: " + monitor.error().message);
  }
  return {};
}

ClusterSummary TrainingRun::Summarize() const {
  ClusterSummary summary = monitor_ ? monitor_->Summarize() : ClusterSummary{};
  for (Fault& fault : faults_.Current()) summary.faults.push_back({"launcher", std::move(fault)});
  return summary;
}

void TrainingRun::FollowFaults() {
  if (clock_.Now() < next_look_) return;
  next_look_ = clock_.Now() + kFaultInterval;
  faults_.Report(FaultKind::kResults, results_writer_.last());
  for (const std::string& line : fault_history_.Update(Summarize().faults, clock_.Now())) {
    display_.Message(line);
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
  ForgetSelection(paths_);
  DADRL_RETURN_IF_ERROR(StartCluster());
  display_.Message(fmt::format("{} run {}: {} replay, 1 learner, {} actors; Ctrl-C stops with a checkpoint",
                               resume_ ? "resumed" : "new", paths_.root.string(), config_.replay.shards,
                               config_.actor.count));
  if (!dds::IsLoopback(config_.cluster.host)) {
    display_.Message(fmt::format("other machines join with: dadrl actor --join {}:{}{}", config_.cluster.host,
                                 config_.cluster.port,
                                 config_.cluster.require_key ? " --key FILE, a copy of this run's key" : ""));
  }
  while (phase_ != Phase::kDone) {
    WaitForEvents();
    if (monitor_) monitor_->Poll(Duration::zero());
    supervisor_.Step();
    ReapAdopted(ChildPids());
    HandleSignals();
    health_.Step(supervisor_, phase_ == Phase::kTraining);
    FollowFaults();
    Advance();
    if (phase_ != Phase::kDone && display_.Due()) display_.Show(MakeProgress());
  }
  return outcome_;
}

void TrainingRun::WaitForEvents() {
  std::vector<pollfd> fds = {{.fd = signals_.fd(), .events = POLLIN, .revents = 0}};
  supervisor_.AppendWaitFds(fds);
  evaluator_.AppendWaitFds(fds);
  const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(supervisor_.NextDeadline(kTick));
  poll(fds.data(), fds.size(), static_cast<int>(wait.count()));
}

std::vector<pid_t> TrainingRun::ChildPids() const {
  std::vector<pid_t> pids = supervisor_.RunningPids();
  const std::vector<pid_t> more = evaluator_.RunningPids();
  pids.insert(pids.end(), more.begin(), more.end());
  return pids;
}

void TrainingRun::AddPause(Duration paused) {
  supervisor_.AddPause(paused);
  health_.AddPause(paused);
  for (TimePoint* time : {&started_, &next_evaluation_, &next_save_}) *time += paused;
}

void TrainingRun::HandleSignals() {
  if (signals_.PauseRequested()) {
    display_.Message("paused with all its processes; fg (or kill -CONT) goes on");
    display_.Finish();
    signals_.PauseWith(ChildPids(), [this](Duration paused) { AddPause(paused); });
  }
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
  if (due && !evaluator_.running() && std::filesystem::exists(paths_.policy(), error)) {
    next_evaluation_ = clock_.Now() + FromSeconds(config_.evaluation.interval_s);
    StartEvaluation(false);
  }
  if (clock_.Now() >= next_episodes_) UpdateEpisodes();
  if (clock_.Now() >= next_save_) {
    next_save_ = clock_.Now() + kSaveInterval;
    SaveResults("running");
  }
}

void TrainingRun::BeginDrain(RunOutcome outcome, const std::string& why) {
  trained_s_ = SessionSeconds();
  outcome_ = outcome;
  phase_ = Phase::kDrainingActors;
  evaluator_.Cancel();
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
  UpdateEpisodes();
  evaluated_at_ = {.elapsed_s = results_.earlier_s() + (final ? trained_s_ : SessionSeconds()),
                   .env_steps = episodes_->env_steps()};
  const Status started = final ? evaluator_.StartFinal() : evaluator_.StartInterim();
  if (!started) display_.Message("evaluation: " + started.error().message);
  return started.has_value();
}

void TrainingRun::AdvanceEvaluation() {
  if (const auto evaluated = evaluator_.Step()) FinishEvaluation(*evaluated);
}

void TrainingRun::FinishEvaluation(const Result<EvaluatedPolicy>& evaluated) {
  const bool final = phase_ == Phase::kFinalEvaluation;
  if (!evaluated) {
    display_.Message("evaluation: " + evaluated.error().message);
    if (final) EndRun(RunOutcome::kFailed);
    return;
  }
  evaluated_at_.updates = evaluated->updates;
  evaluated_at_.policy_version = evaluated->policy_version;
  last_evaluation_ =
      fmt::format("{} updates: {}", Thousands(evaluated->updates), ReportLine(evaluated->report));
  display_.Message(fmt::format("{} after {}", final ? "final evaluation" : "evaluation", last_evaluation_));
  if (final) {
    results_.SetFinal(evaluated_at_, evaluated->report);
    EndRun(RunOutcome::kFinished);
  } else {
    results_.AddEvaluation(evaluated_at_, evaluated->report);
    SaveResults("running");
  }
}

void TrainingRun::KillEverything() {
  display_.Message("killing everything; the last checkpoint stays");
  if (phase_ == Phase::kTraining) trained_s_ = SessionSeconds();
  evaluator_.Cancel();
  supervisor_.KillAll();
  EndRun(RunOutcome::kFailed);
}

}  // namespace dadrl
