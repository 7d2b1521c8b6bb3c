// Writes checkpoints in the background: the training thread pays for a copy in memory, never for the disk.
#pragma once

#include <optional>

#include "common/util/background_thread.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "learner/checkpoint_store.h"

namespace dadrl {

// Owns its thread and one snapshot that it reuses. Begin, Submit and Finish: the training thread; the rest:
// any.
class CheckpointWriter {
 public:
  // Borrows `clock`.
  CheckpointWriter(CheckpointStore store, const Clock& clock);
  // Finishes what was submitted.
  ~CheckpointWriter() = default;

  // The snapshot to fill, or null while the one before is still being written: then try again later. Never
  // blocks.
  Checkpoint* Begin() DADRL_EXCLUDES(mutex_);
  // Hands the filled snapshot over. A failure is a fault of the process, the next checkpoint is a new try.
  void Submit() DADRL_EXCLUDES(mutex_);
  // Waits until nothing is under way; the outcome of the last save.
  Status Finish() DADRL_EXCLUDES(mutex_);

  // When the newest of this process was complete; nothing before the first.
  std::optional<TimePoint> saved_at() const DADRL_EXCLUDES(mutex_);

 private:
  void SaveSubmitted() DADRL_EXCLUDES(mutex_);

  CheckpointStore store_;
  const Clock& clock_;
  Checkpoint snapshot_;  // the training thread's, the writer's while submitted
  mutable Mutex mutex_;
  CondVar changed_;
  bool submitted_ DADRL_GUARDED_BY(mutex_) = false;
  Status last_ DADRL_GUARDED_BY(mutex_);
  std::optional<TimePoint> saved_at_ DADRL_GUARDED_BY(mutex_);
  BackgroundThread thread_;
};

}  // namespace dadrl
