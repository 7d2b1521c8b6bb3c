#include "replay/service/chores.h"

#include <algorithm>
#include <utility>

#include "common/util/log.h"

namespace dadrl {

void Chores::Add(Duration interval, TimePoint first, std::function<Status()> work) {
  chores_.push_back({.interval = interval, .due = first, .work = std::move(work)});
}

void Chores::DoDue() {
  for (Chore& chore : chores_) {
    if (clock_.Now() < chore.due) continue;
    const Status done = chore.work();
    const bool failed_before = std::exchange(chore.failed, !done);
    if (!done && !failed_before) spdlog::error("{}", done.error().message);
    chore.due = clock_.Now() + (done ? chore.interval : std::max(chore.interval, kRetryInterval));
  }
}

}  // namespace dadrl
