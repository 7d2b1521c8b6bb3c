// A mutex that Clang's thread-safety analysis understands; members it guards say DADRL_GUARDED_BY(mutex_).
#pragma once

#include <condition_variable>
#include <mutex>

#include "common/util/clock.h"

#if defined(__clang__)
#define DADRL_ANNOTATION(x) __attribute__((x))
#else
#define DADRL_ANNOTATION(x)
#endif

#define DADRL_CAPABILITY(x) DADRL_ANNOTATION(capability(x))
#define DADRL_SCOPED_CAPABILITY DADRL_ANNOTATION(scoped_lockable)
#define DADRL_GUARDED_BY(x) DADRL_ANNOTATION(guarded_by(x))
#define DADRL_REQUIRES(...) DADRL_ANNOTATION(requires_capability(__VA_ARGS__))
#define DADRL_EXCLUDES(...) DADRL_ANNOTATION(locks_excluded(__VA_ARGS__))
#define DADRL_ACQUIRE(...) DADRL_ANNOTATION(acquire_capability(__VA_ARGS__))
#define DADRL_RELEASE(...) DADRL_ANNOTATION(release_capability(__VA_ARGS__))
#define DADRL_NO_THREAD_SAFETY_ANALYSIS DADRL_ANNOTATION(no_thread_safety_analysis)

namespace dadrl {

class DADRL_CAPABILITY("mutex") Mutex {
 public:
  void Lock() DADRL_ACQUIRE() { mutex_.lock(); }
  void Unlock() DADRL_RELEASE() { mutex_.unlock(); }

 private:
  friend class CondVar;
  std::mutex mutex_;
};

class DADRL_SCOPED_CAPABILITY MutexLock {
 public:
  explicit MutexLock(Mutex& mutex) DADRL_ACQUIRE(mutex) : mutex_(mutex) { mutex_.Lock(); }
  ~MutexLock() DADRL_RELEASE() { mutex_.Unlock(); }
  MutexLock(const MutexLock&) = delete;
  MutexLock& operator=(const MutexLock&) = delete;

 private:
  Mutex& mutex_;
};

// Wait in a loop on the condition: wake-ups may be spurious.
class CondVar {
 public:
  void Wait(Mutex& mutex) DADRL_REQUIRES(mutex) DADRL_NO_THREAD_SAFETY_ANALYSIS {
    std::unique_lock<std::mutex> lock(mutex.mutex_, std::adopt_lock);
    condition_.wait(lock);
    lock.release();
  }
  // False on time-out.
  bool WaitFor(Mutex& mutex, Duration timeout) DADRL_REQUIRES(mutex) DADRL_NO_THREAD_SAFETY_ANALYSIS {
    std::unique_lock<std::mutex> lock(mutex.mutex_, std::adopt_lock);
    const bool notified = condition_.wait_for(lock, timeout) == std::cv_status::no_timeout;
    lock.release();
    return notified;
  }
  void NotifyOne() { condition_.notify_one(); }
  void NotifyAll() { condition_.notify_all(); }

 private:
  std::condition_variable condition_;
};

}  // namespace dadrl
