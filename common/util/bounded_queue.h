// A queue between two threads that cannot grow without bound and can be closed.
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <tuple>
#include <utility>

#include "common/util/mutex.h"

namespace dadrl {

// Thread safe, any number of producers and consumers. After Close: pushes fail, pops drain what is left.
template <typename T>
class BoundedQueue {
 public:
  explicit BoundedQueue(size_t capacity) : capacity_(capacity) {}

  // Never blocks; false (and `item` untouched) when full or closed.
  [[nodiscard]] bool TryPush(T& item) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    if (closed_ || items_.size() >= capacity_) return false;
    items_.push_back(std::move(item));
    changed_.NotifyAll();
    return true;
  }

  // As TryPush, where there is always room, or nobody misses `item`.
  void PushOrDrop(T item) DADRL_EXCLUDES(mutex_) { std::ignore = TryPush(item); }

  // Blocks while full, at most `timeout`; false on time-out or when closed.
  [[nodiscard]] bool Push(T item, Duration timeout) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    const TimePoint deadline = std::chrono::steady_clock::now() + timeout;
    while (!closed_ && items_.size() >= capacity_) {
      const Duration left = deadline - std::chrono::steady_clock::now();
      if (left <= Duration::zero()) return false;
      changed_.WaitFor(mutex_, left);
    }
    if (closed_) return false;
    items_.push_back(std::move(item));
    changed_.NotifyAll();
    return true;
  }

  // Blocks while empty, at most `timeout` (zero: never); nothing on time-out, or when closed and drained.
  std::optional<T> Pop(Duration timeout) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    const TimePoint deadline = std::chrono::steady_clock::now() + timeout;
    while (!closed_ && items_.empty()) {
      const Duration left = deadline - std::chrono::steady_clock::now();
      if (left <= Duration::zero()) return std::nullopt;
      changed_.WaitFor(mutex_, left);
    }
    if (items_.empty()) return std::nullopt;
    std::optional<T> item(std::move(items_.front()));
    items_.pop_front();
    changed_.NotifyAll();
    return item;
  }

  void Close() DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    closed_ = true;
    changed_.NotifyAll();
  }

  size_t size() const DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return items_.size();
  }
  size_t capacity() const { return capacity_; }

 private:
  const size_t capacity_;
  mutable Mutex mutex_;
  CondVar changed_;
  std::deque<T> items_ DADRL_GUARDED_BY(mutex_);
  bool closed_ DADRL_GUARDED_BY(mutex_) = false;
};

}  // namespace dadrl
