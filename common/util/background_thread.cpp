#include "common/util/background_thread.h"

#include <utility>

namespace dadrl {

BackgroundThread::BackgroundThread(Work work) : work_(std::move(work)), thread_([this] { Run(); }) {}

BackgroundThread::~BackgroundThread() {
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  thread_.join();
}

void BackgroundThread::Wake() {
  MutexLock lock(mutex_);
  woken_ = true;
  changed_.NotifyAll();
}

void BackgroundThread::Run() {
  while (!Rest(work_(false))) {
  }
  work_(true);
}

bool BackgroundThread::Rest(Duration rest) {
  const SystemClock clock;
  const TimePoint began = clock.Now();
  MutexLock lock(mutex_);
  while (!woken_ && !stopping_) {
    if (rest == kUntilWoken) {
      changed_.Wait(mutex_);
      continue;
    }
    const Duration left = rest - (clock.Now() - began);
    if (left <= Duration::zero()) break;
    changed_.WaitFor(mutex_, left);
  }
  woken_ = false;
  return stopping_;
}

}  // namespace dadrl
