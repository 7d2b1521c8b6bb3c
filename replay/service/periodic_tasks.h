// What is done again and again: each task at its own interval.
#pragma once

#include <functional>
#include <vector>

#include "common/util/clock.h"
#include "common/util/fault.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe. A failure is a fault of the board until the task succeeds again; and what failed is left
// alone for a while: a full disk does not fill up with attempts.
class PeriodicTasks {
 public:
  static constexpr Duration kRetryInterval = std::chrono::seconds(1);

  // Borrows both.
  PeriodicTasks(const Clock& clock, FaultBoard& faults) : clock_(clock), faults_(faults) {}

  // Every `interval` from `first` on; `fault` is what it is while the work fails.
  void Add(Duration interval, TimePoint first, FaultKind fault, std::function<Status()> work);
  // Those that are due, in the order in which they were added.
  void RunDue();

 private:
  struct Task {
    Duration interval{};
    TimePoint due{};
    FaultKind fault{};
    std::function<Status()> work;
  };
  const Clock& clock_;
  FaultBoard& faults_;
  std::vector<Task> tasks_;
};

}  // namespace dadrl
