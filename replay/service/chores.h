// What is done again and again: each chore at its own interval.
#pragma once

#include <functional>
#include <vector>

#include "common/util/clock.h"
#include "common/util/fault.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe. A failure is a fault of the board until the chore succeeds again; and what failed is left
// alone for a while: a full disk does not fill up with attempts.
class Chores {
 public:
  static constexpr Duration kRetryInterval = std::chrono::seconds(1);

  // Borrows both.
  Chores(const Clock& clock, FaultBoard& faults) : clock_(clock), faults_(faults) {}

  // Every `interval` from `first` on; `fault` is what it is while the work fails.
  void Add(Duration interval, TimePoint first, FaultKind fault, std::function<Status()> work);
  // Those that are due, in the order in which they were added.
  void DoDue();

 private:
  struct Chore {
    Duration interval{};
    TimePoint due{};
    FaultKind fault{};
    std::function<Status()> work;
  };
  const Clock& clock_;
  FaultBoard& faults_;
  std::vector<Chore> chores_;
};

}  // namespace dadrl
