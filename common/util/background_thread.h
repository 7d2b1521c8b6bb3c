// A thread beside its owner, which rests between rounds of work and ends with its owner.
#pragma once

#include <functional>
#include <thread>

#include "common/util/clock.h"
#include "common/util/mutex.h"

namespace dadrl {

// Make it the last member: the work may use what stands before it. Thread safe.
class BackgroundThread {
 public:
  // One round, on this thread; `last` when its owner ends and no other round follows. Returns how long to
  // rest before the next, unless woken: not at all where it is below zero.
  using Work = std::function<Duration(bool last)>;
  // A rest that only Wake ends.
  static constexpr Duration kUntilWoken = Duration::max();

  // The first round comes at once.
  explicit BackgroundThread(Work work);
  // Wakes it for the last round and waits until that is done.
  ~BackgroundThread();
  BackgroundThread(const BackgroundThread&) = delete;
  BackgroundThread& operator=(const BackgroundThread&) = delete;

  // A whole round follows, also when one is under way now. Never blocks.
  void Wake() DADRL_EXCLUDES(mutex_);

 private:
  void Run() DADRL_EXCLUDES(mutex_);
  // True when the owner ends.
  bool Rest(Duration rest) DADRL_EXCLUDES(mutex_);

  const Work work_;
  Mutex mutex_;
  CondVar changed_;
  bool woken_ DADRL_GUARDED_BY(mutex_) = false;
  bool stopping_ DADRL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace dadrl
