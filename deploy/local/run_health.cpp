#include "deploy/local/run_health.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "deploy/local/cluster_processes.h"

namespace dadrl {
namespace {

constexpr Duration kInterval = std::chrono::milliseconds(250);

}  // namespace

RunHealth::RunHealth(std::filesystem::path file, const Clock& clock, FaultBoard& faults)
    : file_(std::move(file)), clock_(clock), faults_(faults), next_(clock.Now()), stall_(clock.Now()) {
  lost_.Skip(clock.Now());
}

void RunHealth::Step(const Supervisor& supervisor, bool training) {
  const TimePoint now = clock_.Now();
  if (now < next_) return;
  next_ = now + kInterval;
  const Supervision before = std::exchange(supervision_, supervisor.Describe());
  if (training) {
    Sum(supervisor, now);
  } else {
    lost_.Skip(now);
    fault_.clear();
  }
  if (supervision_ != before || faults_.Lasts(FaultKind::kProcesses)) {
    faults_.Report(FaultKind::kProcesses, SaveSupervision(file_, supervision_));
  }
}

void RunHealth::Sum(const Supervisor& supervisor, TimePoint now) {
  std::vector<std::string> faults;
  fault_.clear();
  for (const SupervisedProcess& process : supervision_.processes) {
    if (process.fault.empty()) continue;
    faults.push_back(fmt::format("{}: {}", process.name, process.fault));
    if (fault_.empty()) fault_ = fmt::format("{}: {}", process.name, process.trouble);
  }
  const std::string stall = StallOf(supervisor, now);
  if (faults.empty() && !stall.empty()) {
    faults.push_back(stall);
    fault_ = stall;
    lost_.Add(stall, stall_.TakeOverdue());
  }
  lost_.Observe(now, faults);
}

// Without actors of its own a run may wait for others to join.
std::string RunHealth::StallOf(const Supervisor& supervisor, TimePoint now) {
  if (supervisor.RoleEnded(kActorRole)) return {};
  return stall_.Look(now, supervisor.Work(kLearnerRole), supervisor.Work(kReplayRole));
}

void RunHealth::AddPause(Duration paused) {
  stall_.AddPause(paused);
  lost_.Skip(clock_.Now());
}

}  // namespace dadrl
