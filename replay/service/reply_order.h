// Lets several threads prepare replies at once and send them in the order in which they were drawn.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>

#include "common/util/mutex.h"

namespace dadrl {

// Thread safe. Every place that was taken must be left, first taken first.
class ReplyOrder {
 public:
  // What a place is taken for.
  struct Request {
    uint64_t learner = 0;
    uint64_t number = 0;
    bool operator==(const Request&) const = default;
  };

  // Behind all that were taken before.
  void TakePlace(const Request& request) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    places_.push_back(request);
  }
  // Blocks until every place before that of `request` was left.
  void WaitForTurn(const Request& request) DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    while (places_.front() != request) left_.Wait(mutex_);
  }
  // The first place.
  void Leave() DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    places_.pop_front();
    left_.NotifyAll();
  }
  bool Holds(const Request& request) const DADRL_EXCLUDES(mutex_) {
    MutexLock lock(mutex_);
    return std::find(places_.begin(), places_.end(), request) != places_.end();
  }

 private:
  mutable Mutex mutex_;
  CondVar left_;
  std::deque<Request> places_ DADRL_GUARDED_BY(mutex_);
};

}  // namespace dadrl
