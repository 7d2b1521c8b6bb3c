#include "learner/checkpoint_writer.h"

#include <utility>

#include "common/util/fault.h"
#include "common/util/log.h"

namespace dadrl {

CheckpointWriter::CheckpointWriter(CheckpointStore store, const Clock& clock)
    : store_(std::move(store)), clock_(clock), thread_([this](bool) {
        SaveSubmitted();
        return BackgroundThread::kUntilWoken;
      }) {}

Checkpoint* CheckpointWriter::Begin() {
  MutexLock lock(mutex_);
  return submitted_ ? nullptr : &snapshot_;
}

void CheckpointWriter::Submit() {
  {
    MutexLock lock(mutex_);
    submitted_ = true;
  }
  thread_.Wake();
}

Status CheckpointWriter::Finish() {
  MutexLock lock(mutex_);
  while (submitted_) changed_.Wait(mutex_);
  return last_;
}

std::optional<TimePoint> CheckpointWriter::saved_at() const {
  MutexLock lock(mutex_);
  return saved_at_;
}

void CheckpointWriter::SaveSubmitted() {
  {
    MutexLock lock(mutex_);
    if (!submitted_) return;
  }
  Status saved = store_.Save(snapshot_);
  if (saved) {
    spdlog::info("checkpoint at {} updates, weights version {}", snapshot_.updates,
                 snapshot_.weights_version);
  }
  ProcessFaults().Report(FaultKind::kCheckpoint, saved);
  MutexLock lock(mutex_);
  if (saved) saved_at_ = clock_.Now();
  last_ = std::move(saved);
  submitted_ = false;
  changed_.NotifyAll();
}

}  // namespace dadrl
