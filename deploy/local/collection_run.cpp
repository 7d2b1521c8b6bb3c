#include "deploy/local/collection_run.h"

#include <algorithm>
#include <utility>

#include "deploy/local/cluster_processes.h"

namespace dadrl {
namespace {

constexpr Duration kTick = std::chrono::milliseconds(100);
// Counting reads all that is stored: a little of the time.
constexpr Duration kCountInterval = std::chrono::seconds(1);
constexpr int kCountShare = 20;
constexpr Duration kWordInterval = std::chrono::seconds(10);

}  // namespace

bool CollectionGoal::ReachedBy(const StoredEpisodes& stored) const {
  return stored.episodes >= episodes && stored.successes >= successes;
}

CollectionRun::CollectionRun(const RunPaths& paths, const Config& config, const CollectionGoal& goal,
                             SignalWatcher& signals, std::function<void(const std::string&)> say,
                             EpisodeLog episodes)
    : paths_(paths),
      config_(config),
      goal_(goal),
      signals_(signals),
      say_(std::move(say)),
      supervisor_(RestartLimits{}, HangLimits::Of(config.cluster), clock_, say_),
      episodes_(std::move(episodes)),
      counter_(paths.replay()) {}

Result<std::unique_ptr<CollectionRun>> CollectionRun::Create(const RunPaths& paths, const Config& config,
                                                             const CollectionGoal& goal,
                                                             SignalWatcher& signals,
                                                             std::function<void(const std::string&)> say) {
  DADRL_ASSIGN_OR_RETURN(EpisodeLog episodes, EpisodeLog::Open(paths.episodes(), paths.logs()));
  return std::unique_ptr<CollectionRun>(
      new CollectionRun(paths, config, goal, signals, std::move(say), std::move(episodes)));
}

Status CollectionRun::Start() {
  DADRL_ASSIGN_OR_RETURN(std::vector<ProcessSpec> specs, ClusterProcesses(paths_, config_));
  for (ProcessSpec& spec : specs) {
    if (spec.role == kLearnerRole) continue;
    DADRL_RETURN_IF_ERROR(supervisor_.Start(std::move(spec)));
  }
  return {};
}

Result<CollectionOutcome> CollectionRun::Run() {
  BecomeSubreaper();
  DADRL_RETURN_IF_ERROR(Start());
  next_count_ = clock_.Now() + kCountInterval;
  next_word_ = clock_.Now() + kWordInterval;
  while (phase_ != Phase::kDone) {
    WaitForEvents();
    supervisor_.Step();
    ReapAdopted(ChildPids());
    HandleSignals();
    Count();
    Advance();
  }
  if (const Status written = episodes_.Update(); !written) say_(written.error().message);
  return outcome_;
}

void CollectionRun::WaitForEvents() {
  std::vector<pollfd> fds = {{.fd = signals_.fd(), .events = POLLIN, .revents = 0}};
  supervisor_.AppendWaitFds(fds);
  counter_.AppendWaitFds(fds);
  const auto wait = std::chrono::duration_cast<std::chrono::milliseconds>(supervisor_.NextDeadline(kTick));
  poll(fds.data(), fds.size(), static_cast<int>(wait.count()));
}

std::vector<pid_t> CollectionRun::ChildPids() const {
  std::vector<pid_t> pids = supervisor_.RunningPids();
  std::ranges::copy(counter_.RunningPids(), std::back_inserter(pids));
  return pids;
}

void CollectionRun::HandleSignals() {
  if (signals_.PauseRequested()) {
    signals_.PauseWith(ChildPids(), [this](Duration paused) { supervisor_.AddPause(paused); });
  }
  if (signals_.KillRequested()) {
    supervisor_.KillAll();
    outcome_ = CollectionOutcome::kFailed;
    phase_ = Phase::kDone;
  } else if (signals_.StopRequested()) {
    End(CollectionOutcome::kInterrupted, "stopping; once more Ctrl-C kills what has not been stored");
  }
}

void CollectionRun::End(CollectionOutcome outcome, const std::string& why) {
  if (phase_ != Phase::kCollecting) return;
  say_(why);
  outcome_ = outcome;
  phase_ = Phase::kDrainingActors;
}

// Takes a count that is done, and begins the next when it is due.
void CollectionRun::Count() {
  const TimePoint now = clock_.Now();
  if (auto counted = counter_.Step()) {
    // One that has just begun holds nothing that could be read.
    trouble_ = *counted ? std::string() : counted->error().message;
    if (*counted) stored_ = **counted;
    const Duration took = now - (next_count_ - kCountInterval);
    next_count_ = now + std::max(kCountInterval, kCountShare * took);
    if (phase_ == Phase::kLastCount) phase_ = Phase::kDone;
  }
  if (phase_ != Phase::kCollecting && phase_ != Phase::kLastCount) return;
  if (counter_.counting() || (now < next_count_ && phase_ == Phase::kCollecting)) return;
  next_count_ = now + kCountInterval;
  if (const Status begun = counter_.Begin(); !begun) End(CollectionOutcome::kFailed, begun.error().message);
}

void CollectionRun::Advance() {
  switch (phase_) {
    case Phase::kCollecting:
      if (goal_.ReachedBy(stored_)) return End(CollectionOutcome::kFinished, "enough is stored");
      if (const auto lost = supervisor_.Lost()) {
        return End(CollectionOutcome::kFailed, "collecting cannot go on: " + *lost);
      }
      if (clock_.Now() < next_word_) return;
      next_word_ = clock_.Now() + kWordInterval;
      if (const Status written = episodes_.Update(); !written) say_(written.error().message);
      if (!trouble_.empty()) say_(trouble_);
      return say_(fmt::format("{} episodes stored, {} of them successes, {} frames", stored_.episodes,
                              stored_.successes, stored_.frames));
    case Phase::kDrainingActors:
      return Drain(kActorRole, Phase::kDrainingReplay);
    case Phase::kDrainingReplay:
      return Drain(kReplayRole, Phase::kLastCount);
    case Phase::kLastCount:
    case Phase::kDone:
      break;
  }
}

void CollectionRun::Drain(const char* role, Phase next) {
  if (supervisor_.RoleEnded(role)) {
    phase_ = next;
  } else if (supervisor_.Count(role, ProcessState::kStopping) == 0) {
    supervisor_.StopRole(role);
  }
}

}  // namespace dadrl
