#include "replay/service/periodic_tasks.h"

#include <algorithm>
#include <utility>

namespace dadrl {

void PeriodicTasks::Add(Duration interval, TimePoint first, FaultKind fault, std::function<Status()> work) {
  tasks_.push_back({.interval = interval, .due = first, .fault = fault, .work = std::move(work)});
}

void PeriodicTasks::RunDue() {
  for (Task& task : tasks_) {
    if (clock_.Now() < task.due) continue;
    const Status done = task.work();
    faults_.Report(task.fault, done);
    task.due = clock_.Now() + (done ? task.interval : std::max(task.interval, kRetryInterval));
  }
}

}  // namespace dadrl
