#include "learner/checkpoint_writer.h"

#include <utility>

#include "common/util/fault.h"
#include "common/util/log.h"

namespace dadrl {

CheckpointWriter::CheckpointWriter(CheckpointStore store, const Clock& clock)
    : store_(std::move(store)), clock_(clock), thread_([this] { Run(); }) {}

CheckpointWriter::~CheckpointWriter() {
  // A failure was logged when it happened; there is nobody left to tell.
  static_cast<void>(Finish());
  {
    MutexLock lock(mutex_);
    state_ = State::kStopping;
    changed_.NotifyAll();
  }
  thread_.join();
}

Checkpoint* CheckpointWriter::Begin() {
  MutexLock lock(mutex_);
  return state_ == State::kIdle ? &snapshot_ : nullptr;
}

void CheckpointWriter::Submit() {
  MutexLock lock(mutex_);
  state_ = State::kSubmitted;
  changed_.NotifyAll();
}

Status CheckpointWriter::Finish() {
  MutexLock lock(mutex_);
  while (state_ == State::kSubmitted) changed_.Wait(mutex_);
  return last_;
}

CheckpointWriter::Progress CheckpointWriter::progress() const {
  MutexLock lock(mutex_);
  return progress_;
}

void CheckpointWriter::Run() {
  while (true) {
    {
      MutexLock lock(mutex_);
      while (state_ == State::kIdle) changed_.Wait(mutex_);
      if (state_ == State::kStopping) return;
    }
    Status saved = store_.Save(snapshot_);
    if (saved) {
      spdlog::info("checkpoint at {} updates, weights version {}", snapshot_.updates,
                   snapshot_.weights_version);
    }
    ProcessFaults().Report(FaultKind::kCheckpoint, saved);
    MutexLock lock(mutex_);
    if (saved) {
      ++progress_.saved;
      progress_.saved_at = clock_.Now();
      progress_.saved_updates = snapshot_.updates;
    } else {
      ++progress_.failed;
    }
    last_ = std::move(saved);
    state_ = State::kIdle;
    changed_.NotifyAll();
  }
}

}  // namespace dadrl
