#include "learner/trainer.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/config/config_yaml.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

// How long the loop waits before it looks again at `stop`, the limits and the reason for waiting.
constexpr Duration kSlice = std::chrono::milliseconds(100);
// What a disk may take for the last checkpoint before the process is taken to hang.
constexpr Duration kSlowDisk = std::chrono::minutes(5);
// Of the last checkpoint, on a disk that takes no writes: how long until the next attempt, and how many there
// are once somebody waits for the end.
constexpr Duration kSaveRetry = std::chrono::seconds(1);
constexpr int kLastAttempts = 10;

}  // namespace

Trainer::Trainer(const Config& config, const Parts& parts, const TrainingProgress& progress)
    : config_(config),
      config_yaml_(ToYaml(config, false)),
      parts_(parts),
      guard_(config, scalar_specs()),
      sends_priorities_(parts.algorithm.spec().gives_priorities && UsesPriorities(config.replay)),
      ledger_(parts.clock),
      started_(parts.clock.Now()),
      trained_before_s_(progress.trained_s),
      cpu_before_s_(progress.cpu_s - ToSeconds(parts.cpu_time())),
      published_at_(started_),
      checkpointed_at_(started_),
      publish_now_(progress.updates > 0 || parts.algorithm.spec().acts_from_start),
      updates_(progress.updates),
      weights_version_(progress.weights_version),
      staleness_(progress.weights_version, progress.published_ns),
      means_(scalar_specs().size()),
      shared_updates_(progress.updates) {}

TrajectoryBatch* Trainer::WaitForBatch(Duration timeout) {
  if (TrajectoryBatch* ready = parts_.batches.Take(Duration::zero())) return ready;
  ledger_.Enter(parts_.batches.waiting_for());
  return parts_.batches.Take(timeout);
}

Result<Trainer::Step> Trainer::RunStep(Duration timeout) {
  Beat();
  if (publish_now_) {
    publish_now_ = false;
    DADRL_RETURN_IF_ERROR(Publish());
  }
  TrajectoryBatch* batch = WaitForBatch(timeout);
  if (batch == nullptr) {
    DADRL_RETURN_IF_ERROR(parts_.batches.status());
    return Step::kNoBatch;
  }
  ledger_.Enter(Activity::kWork);
  Status sound = parts_.algorithm.Update(*batch);
  if (sound) {
    ReportWork(++updates_);
    sound = guard_.Check(parts_.algorithm.scalars(), updates_);
  }
  if (!sound) {
    parts_.batches.Release(batch);
    return tl::unexpected<Error>(std::move(sound.error()));
  }
  {
    MutexLock lock(mutex_);
    means_.Add(parts_.algorithm.scalars());
    ++interval_updates_;
    shared_updates_ = updates_;
    staleness_.Add(*batch);
  }
  if (sends_priorities_) parts_.batches.UpdatePriorities(*batch, parts_.algorithm.priorities());
  parts_.batches.Release(batch);
  DADRL_RETURN_IF_ERROR(PublishIfDue());
  DADRL_RETURN_IF_ERROR(CheckpointIfDue());
  return Step::kUpdated;
}

Status Trainer::PublishIfDue() {
  const bool first = weights_version_.load(std::memory_order_relaxed) == 0;
  const double since_s = ToSeconds(parts_.clock.Now() - published_at_);
  if (!first && since_s < config_.learner.publish_interval_s) return {};
  return Publish();
}

Status Trainer::Publish() {
  DADRL_RETURN_IF_ERROR(RequireFinitePolicy());
  const uint32_t version = weights_version_.load(std::memory_order_relaxed) + 1;
  const NamedNetwork policy = parts_.algorithm.published_policy();
  parts_.publisher.Publish(
      {.version = version, .layout_hash = policy.layout_hash, .parameters = policy.parameters});
  weights_version_.store(version, std::memory_order_relaxed);
  published_at_ = parts_.clock.Now();
  MutexLock lock(mutex_);
  staleness_.OnPublish(version, parts_.clock.WallTimeNs());
  return {};
}

// The algorithm checks its losses; this is the last gate before actors and files.
Status Trainer::RequireFinitePolicy() const {
  const std::span<const float> policy = parts_.algorithm.published_policy().parameters;
  const auto bad = std::find_if_not(policy.begin(), policy.end(), [](float v) { return std::isfinite(v); });
  if (bad == policy.end()) return {};
  return Fail(ErrorCode::kInternal,
              "parameter {} of the policy is not finite after {} updates: it is neither published nor saved; "
              "resume from the last checkpoint with a smaller learning rate",
              bad - policy.begin(), updates_);
}

Status Trainer::CheckpointIfDue() {
  if (ToSeconds(parts_.clock.Now() - checkpointed_at_) < config_.learner.checkpoint_interval_s) return {};
  DADRL_ASSIGN_OR_RETURN(const bool begun, BeginCheckpoint());
  if (begun) checkpointed_at_ = parts_.clock.Now();
  return {};
}

// False while the one before is still being written: a disk slower than the interval delays checkpoints, not
// training.
Result<bool> Trainer::BeginCheckpoint() {
  DADRL_RETURN_IF_ERROR(RequireFinitePolicy());
  Checkpoint* snapshot = parts_.checkpoints.Begin();
  if (snapshot == nullptr) return false;
  CaptureState(parts_.algorithm, *snapshot);
  snapshot->updates = updates_;
  snapshot->weights_version = weights_version_.load(std::memory_order_relaxed);
  snapshot->trained_s = TrainedSeconds();
  snapshot->cpu_s = CpuSeconds();
  snapshot->config_yaml = config_yaml_;
  {
    MutexLock lock(mutex_);
    snapshot->published_ns = staleness_.published_ns();
  }
  parts_.checkpoints.Submit();
  return true;
}

Status Trainer::SaveNow() {
  // Whatever the one before came to, this one decides.
  std::ignore = parts_.checkpoints.Finish();
  DADRL_ASSIGN_OR_RETURN([[maybe_unused]] const bool begun, BeginCheckpoint());
  return parts_.checkpoints.Finish();
}

Result<std::string> Trainer::Run(const std::atomic<bool>& stop) {
  const WorkingThread working("train");
  std::string reason;
  while (reason.empty()) {
    if (stop.load()) {
      reason = "asked to stop";
    } else {
      reason = LimitReached();
    }
    if (!reason.empty()) break;
    auto step = RunStep(kSlice);
    if (!step) return tl::unexpected<Error>(std::move(step.error()));
  }
  DADRL_RETURN_IF_ERROR(SaveAtEnd(stop));
  return fmt::format("{} after {} updates", reason, updates_);
}

// What was trained since the last checkpoint is worth waiting for.
Status Trainer::SaveAtEnd(const std::atomic<bool>& stop) {
  const LongWork last_checkpoint(kSlowDisk);
  const ScopedActivity saving(ledger_, Activity::kWaitForDisk);
  DADRL_RETURN_IF_ERROR(RequireFinitePolicy());  // that will not pass
  Status saved = SaveNow();
  for (int attempts = 1; !saved && attempts < kLastAttempts; attempts += stop.load() ? 1 : 0) {
    parts_.clock.SleepFor(kSaveRetry);
    Beat();
    saved = SaveNow();
  }
  return saved;
}

double Trainer::TrainedSeconds() const {
  return trained_before_s_ + ToSeconds(parts_.clock.Now() - started_ - parts_.paused_time());
}

double Trainer::CpuSeconds() const { return cpu_before_s_ + ToSeconds(parts_.cpu_time()); }

std::string Trainer::LimitReached() const {
  const auto max_updates = static_cast<uint64_t>(config_.learner.max_updates);
  if (max_updates > 0 && updates_ >= max_updates) {
    return fmt::format("learner.max_updates of {} reached", max_updates);
  }
  const double max_cpu_seconds = config_.learner.max_cpu_seconds;
  if (max_cpu_seconds > 0.0 && CpuSeconds() >= max_cpu_seconds) {
    return fmt::format("learner.max_cpu_seconds of {} reached", max_cpu_seconds);
  }
  if (config_.minutes > 0.0 && TrainedSeconds() >= 60.0 * config_.minutes) {
    return fmt::format("minutes of {} reached", config_.minutes);
  }
  return {};
}

TrainingInterval Trainer::TakeInterval() {
  MutexLock lock(mutex_);
  TrainingInterval interval{.updates = shared_updates_,
                            .weights_version = weights_version(),
                            .trained_s = TrainedSeconds(),
                            .cpu_s = CpuSeconds(),
                            .interval_updates = interval_updates_,
                            .scalars = means_.Take(),
                            .staleness = staleness_.TakeInterval()};
  interval_updates_ = 0;
  return interval;
}

}  // namespace dadrl
