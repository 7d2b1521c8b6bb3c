// The training loop: takes a batch, updates, publishes, checkpoints. Knows no network, no disk and no
// process: those come in as interfaces, so the same loop trains in the learner process and in lockstep inside
// one process.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/liveness/working_thread.h"
#include "common/step/trajectory_batch.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "learner/algorithms/algorithm.h"
#include "learner/batch_source.h"
#include "learner/checkpoint_writer.h"
#include "learner/divergence.h"
#include "learner/policy_publisher.h"
#include "learner/scalar_means.h"
#include "learner/staleness.h"

namespace dadrl {

// Where a training stands; zero for a new one, from the checkpoint for a resumed one.
struct TrainingProgress {
  uint64_t updates = 0;
  uint32_t weights_version = 0;  // the next one published is greater
  double trained_s = 0.0;
  double cpu_s = 0.0;
  std::vector<int64_t> published_ns;
};

// What an interval of training looked like.
struct TrainingInterval {
  uint64_t updates = 0;  // cumulative
  uint32_t weights_version = 0;
  double trained_s = 0.0;  // cumulative
  double cpu_s = 0.0;      // cumulative, processor time
  uint64_t interval_updates = 0;
  std::vector<double> scalars;  // means over the interval, as Algorithm::scalars; NaN: no update gave one
  Staleness staleness;          // over the interval
};

class Trainer {
 public:
  // Borrowed; they outlive the trainer.
  struct Parts {
    Algorithm& algorithm;
    BatchSource& batches;
    PolicyPublisher& publisher;
    CheckpointWriter& checkpoints;
    Clock& clock;
    Duration (*paused_time)() =
        &PausedTime;  // of the time since the start, what the process was kept stopped
    Duration (*cpu_time)() = &ProcessCpuTime;  // processor time that counts for this training
  };
  Trainer(const Config& config, const Parts& parts, const TrainingProgress& progress);

  // The training thread.

  enum class Step { kNoBatch, kUpdated };
  // Waits for a batch, at most `timeout`, and trains on it; publishes and checkpoints when due. The first
  // policy is published after the first update, or at once as AlgorithmSpec says; a resumed one at once.
  // Errors: what Algorithm::Update, DivergenceGuard and BatchSource::status say; nothing is published or
  // saved from then on.
  Result<Step> RunStep(Duration timeout);

  // A WorkingThread: steps until `stop`, max_updates, max_cpu_seconds or minutes, then saves a last
  // checkpoint and waits for it: on a disk that takes none until it does, or until ten seconds after `stop`.
  // Returns why it ended, as a sentence.
  Result<std::string> Run(const std::atomic<bool>& stop);

  // Saves a checkpoint of now and waits until it is on disk.
  Status SaveNow();

  // Any thread.

  // One caller: each call starts a new interval.
  TrainingInterval TakeInterval() DADRL_EXCLUDES(mutex_);
  std::span<const ScalarSpec> scalar_specs() const { return parts_.algorithm.spec().scalars; }
  uint32_t weights_version() const { return weights_version_.load(std::memory_order_relaxed); }
  const TimeLedger& ledger() const { return ledger_; }

 private:
  TrajectoryBatch* WaitForBatch(Duration timeout);
  Status PublishIfDue();
  Status SaveAtEnd(const std::atomic<bool>& stop);
  Status CheckpointIfDue();
  Status Publish();
  Result<bool> BeginCheckpoint();
  Status RequireFinitePolicy() const;
  double TrainedSeconds() const;
  double CpuSeconds() const;
  std::string LimitReached() const;

  const Config config_;
  const std::string config_yaml_;
  Parts parts_;
  const DivergenceGuard guard_;
  const bool sends_priorities_;
  TimeLedger ledger_;
  const TimePoint started_;
  const double trained_before_s_;
  const double cpu_before_s_;
  TimePoint published_at_;
  TimePoint checkpointed_at_;
  bool publish_now_;  // actors should not wait for an update
  uint64_t updates_;
  std::atomic<uint32_t> weights_version_;

  mutable Mutex mutex_;
  StalenessTracker staleness_ DADRL_GUARDED_BY(mutex_);
  ScalarMeans means_ DADRL_GUARDED_BY(mutex_);
  uint64_t interval_updates_ DADRL_GUARDED_BY(mutex_) = 0;
  uint64_t shared_updates_ DADRL_GUARDED_BY(mutex_) = 0;  // updates_ as other threads see it
};

}  // namespace dadrl
