// Tells whether a training gets on, by what its processes say that they came to.
#pragma once

#include <cstdint>
#include <string>

#include "common/util/clock.h"

namespace dadrl {

// A training gets on while updates are made that were not made before, or frames are stored: a learner may
// wait for experience, and actors for the learner, but not both at once. Pure; not thread safe.
class StallWatch {
 public:
  // Standing still for so long is a fault; so long may the first processes take to come up.
  static constexpr Duration kPatience = std::chrono::seconds(10);
  static constexpr Duration kFirstPatience = std::chrono::seconds(60);

  explicit StallWatch(TimePoint now) : moved_(now) {}

  // `updates` of the learner that runs, over the whole run (0: it has not begun); `frames`: any number that
  // changes when a replay stores some. The fault, when it does not get on ("the learner repeats 120 updates"
  // counts too: that work was lost).
  std::string Look(TimePoint now, uint64_t updates, uint64_t frames);
  // Time to forget: the run was kept stopped.
  void AddPause(Duration paused) { moved_ += paused; }
  // Of the fault that Look began to name now: how long it had lasted. Once.
  Duration TakeOverdue();

 private:
  uint64_t most_updates_ = 0;
  uint64_t frames_ = 0;
  bool begun_ = false;
  bool stalled_ = false;
  TimePoint moved_;
  Duration overdue_{};
};

}  // namespace dadrl
