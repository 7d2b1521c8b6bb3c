// What a Supervisor tells of its processes.
#include <unistd.h>

#include "deploy/local/supervisor.h"

namespace dadrl {
namespace {

const char* StateName(ProcessState state, bool begun) {
  switch (state) {
    case ProcessState::kRunning:
      return begun ? "running" : "starting";
    case ProcessState::kWaiting:
      return "restarting";
    case ProcessState::kStopping:
      return "stopping";
    case ProcessState::kStopped:
    case ProcessState::kFinished:
      return "ended";
    case ProcessState::kGivenUp:
      return "given up";
  }
  return "";
}

}  // namespace

Supervision Supervisor::Describe() const {
  Supervision supervision{.launcher = getpid(), .processes = {}};
  for (const Entry& entry : entries_) supervision.processes.push_back(Describe(entry));
  return supervision;
}

SupervisedProcess Supervisor::Describe(const Entry& entry) const {
  const bool begun = entry.watch->begun();
  SupervisedProcess process{.name = entry.spec.name,
                            .pid = entry.child ? entry.child->pid() : 0,
                            .state = StateName(entry.state, begun),
                            .trouble = {},
                            .fault = {},
                            .restarts = entry.restarts,
                            .hangs = entry.hangs,
                            .last_end = entry.last_end,
                            .since_ns = entry.changed_ns};
  if (entry.state == ProcessState::kGivenUp) {
    process.trouble = fmt::format("given up: {}", entry.give_up_reason);
  } else if (!entry.hung.empty()) {
    process.trouble = fmt::format("hangs: {}", entry.hung);
    process.fault = "hangs";
  } else if (entry.state == ProcessState::kWaiting ||
             (entry.state == ProcessState::kRunning && entry.restarts > 0 && !begun)) {
    process.trouble = fmt::format("starts again: {}", entry.last_end);
    process.fault = "starts again";
  } else if (entry.state == ProcessState::kRunning) {
    process.trouble = entry.watch->Suspicion();
    if (!process.trouble.empty()) process.fault = "hangs";
    if (const std::string fault = entry.watch->Fault(); process.trouble.empty()) {
      process.trouble = process.fault = fault;
    }
  }
  if (Expendable(entry)) process.fault.clear();
  return process;
}

uint64_t Supervisor::Work(std::string_view role) const {
  uint64_t work = 0;
  for (const Entry& entry : entries_) {
    if (entry.spec.role == role && entry.watch) work += entry.watch->work();
  }
  return work;
}

}  // namespace dadrl
