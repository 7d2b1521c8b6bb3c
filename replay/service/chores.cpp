#include "replay/service/chores.h"

#include <algorithm>
#include <utility>

namespace dadrl {

void Chores::Add(Duration interval, TimePoint first, FaultKind fault, std::function<Status()> work) {
  chores_.push_back({.interval = interval, .due = first, .fault = fault, .work = std::move(work)});
}

void Chores::DoDue() {
  for (Chore& chore : chores_) {
    if (clock_.Now() < chore.due) continue;
    const Status done = chore.work();
    faults_.Report(chore.fault, done);
    chore.due = clock_.Now() + (done ? chore.interval : std::max(chore.interval, kRetryInterval));
  }
}

}  // namespace dadrl
