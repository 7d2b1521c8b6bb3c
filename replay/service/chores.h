// What is done again and again: each chore at its own interval.
#pragma once

#include <functional>
#include <vector>

#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe. A failure is logged once, until the chore succeeds again; and what failed is left alone
// for a while: a full disk does not fill up with attempts.
class Chores {
 public:
  static constexpr Duration kRetryInterval = std::chrono::seconds(1);

  // Borrows `clock`.
  explicit Chores(const Clock& clock) : clock_(clock) {}

  // Every `interval` from `first` on.
  void Add(Duration interval, TimePoint first, std::function<Status()> work);
  // Those that are due, in the order in which they were added.
  void DoDue();

 private:
  struct Chore {
    Duration interval{};
    TimePoint due{};
    std::function<Status()> work;
    bool failed = false;
  };
  const Clock& clock_;
  std::vector<Chore> chores_;
};

}  // namespace dadrl
