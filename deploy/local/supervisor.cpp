#include "deploy/local/supervisor.h"

#include <algorithm>
#include <csignal>
#include <utility>

#include "deploy/local/log_tail.h"

namespace dadrl {
namespace {

// Without a report, a process that stays up this long is taken to have come up.
constexpr Duration kReadyByAge = std::chrono::seconds(20);
constexpr size_t kTailLines = 8;

bool IsUp(ProcessState state) { return state == ProcessState::kRunning || state == ProcessState::kStopping; }
bool WillRun(ProcessState state) { return IsUp(state) || state == ProcessState::kWaiting; }

}  // namespace

Supervisor::Supervisor(const RestartLimits& limits, const Clock& clock, Notice notice)
    : limits_(limits), clock_(clock), notice_(std::move(notice)) {}

Status Supervisor::Start(ProcessSpec spec, bool resumed) {
  const uint64_t seed = DeriveSeed(static_cast<uint64_t>(WallTimeNs()), entries_.size());
  Entry entry{
      .spec = std::move(spec), .policy = RestartPolicy(limits_, seed), .child = {}, .give_up_reason = {}};
  DADRL_RETURN_IF_ERROR(Launch(entry, resumed));
  entries_.push_back(std::move(entry));
  return {};
}

Status Supervisor::Launch(Entry& entry, bool restart) {
  DADRL_ASSIGN_OR_RETURN(entry.child, ChildProcess::Spawn({.command = entry.spec.command(restart),
                                                           .log = entry.spec.log,
                                                           .nice = entry.spec.nice}));
  entry.state = ProcessState::kRunning;
  entry.ready = entry.killed = false;
  entry.started = clock_.Now();
  return {};
}

void Supervisor::AppendWaitFds(std::vector<pollfd>& fds) const {
  for (const Entry& entry : entries_) {
    if (entry.child) fds.push_back({.fd = entry.child->pidfd(), .events = POLLIN, .revents = 0});
  }
}

Duration Supervisor::NextDeadline(Duration limit) const {
  Duration next = limit;
  const TimePoint now = clock_.Now();
  for (const Entry& entry : entries_) {
    const bool timed = entry.state == ProcessState::kWaiting || entry.state == ProcessState::kStopping;
    if (timed && !entry.killed) {
      next = std::min(next, std::max(Duration::zero(), entry.due - now));
    }
  }
  return next;
}

void Supervisor::Step() {
  for (Entry& entry : entries_) {
    if (entry.child) {
      if (const auto status = entry.child->TryWait()) OnEnded(entry, *status);
    }
    if (entry.state == ProcessState::kStopping && !entry.killed && clock_.Now() >= entry.due) {
      notice_(fmt::format("{} did not end within {:g} s and is killed", entry.spec.name,
                          ToSeconds(entry.spec.stop_grace)));
      Kill(entry);
    }
    if (entry.state == ProcessState::kWaiting && clock_.Now() >= entry.due) {
      const Status launched = Launch(entry, true);
      if (!launched) {
        notice_(launched.error().message);
        Decide(entry, Ended{.status = {.signaled = false, .value = 1}});
      }
    }
  }
}

void Supervisor::Kill(Entry& entry) {
  entry.state = ProcessState::kStopping;
  entry.killed = true;
  entry.child->Signal(SIGKILL);
}

void Supervisor::OnEnded(Entry& entry, const ExitStatus& status) {
  entry.child.reset();
  if (entry.state == ProcessState::kStopping) {
    entry.state = ProcessState::kStopped;
    if (!status.success() && !entry.killed) {
      notice_(WithLogTail(
          entry, fmt::format("{} ended with {} while stopping", entry.spec.name, status.Describe())));
    }
    return;
  }
  if (entry.spec.may_finish && status.success()) {
    entry.state = ProcessState::kFinished;
    return;
  }
  const Duration uptime = clock_.Now() - entry.started;
  Decide(entry, Ended{.status = status, .uptime = uptime, .was_ready = entry.ready || uptime >= kReadyByAge});
}

void Supervisor::Decide(Entry& entry, const Ended& ended) {
  const RestartDecision decision = entry.policy.OnEnd(clock_.Now(), ended);
  const std::string what = fmt::format("{} ended with {}", entry.spec.name, ended.status.Describe());
  if (const auto* restart = std::get_if<RestartAfter>(&decision)) {
    entry.state = ProcessState::kWaiting;
    entry.due = clock_.Now() + restart->delay;
    notice_(fmt::format("{}; starting it again in {:.1f} s", what, ToSeconds(restart->delay)));
    return;
  }
  entry.state = ProcessState::kGivenUp;
  entry.give_up_reason = std::get<GiveUp>(decision).reason;
  notice_(WithLogTail(entry, fmt::format("{}; not started again: {}", what, entry.give_up_reason)));
}

std::string Supervisor::WithLogTail(const Entry& entry, std::string text) const {
  if (entry.spec.log.empty()) return text;
  text += fmt::format("; the end of {}:", entry.spec.log.string());
  for (const std::string& line : LogTail(entry.spec.log, kTailLines)) text += "\n  | " + line;
  return text;
}

void Supervisor::MarkReady(pid_t pid) {
  for (Entry& entry : entries_) {
    if (entry.child && entry.child->pid() == pid) entry.ready = true;
  }
}

void Supervisor::StopRole(std::string_view role) {
  for (Entry& entry : entries_) {
    if (entry.spec.role != role) continue;
    if (entry.state == ProcessState::kWaiting) entry.state = ProcessState::kStopped;
    if (entry.state != ProcessState::kRunning) continue;
    entry.state = ProcessState::kStopping;
    entry.due = clock_.Now() + entry.spec.stop_grace;
    entry.child->Signal(SIGTERM);
  }
}

void Supervisor::KillAll() {
  for (Entry& entry : entries_) {
    if (entry.state == ProcessState::kWaiting) entry.state = ProcessState::kStopped;
    if (!IsUp(entry.state)) continue;
    Kill(entry);
  }
}

bool Supervisor::RoleEnded(std::string_view role) const {
  return std::none_of(entries_.begin(), entries_.end(),
                      [&](const Entry& entry) { return entry.spec.role == role && WillRun(entry.state); });
}

bool Supervisor::AllEnded() const {
  return std::none_of(entries_.begin(), entries_.end(),
                      [](const Entry& entry) { return WillRun(entry.state); });
}

int Supervisor::Count(std::string_view role, ProcessState state) const {
  return static_cast<int>(std::count_if(entries_.begin(), entries_.end(), [&](const Entry& entry) {
    return entry.spec.role == role && entry.state == state;
  }));
}

std::vector<pid_t> Supervisor::RunningPids() const {
  std::vector<pid_t> pids;
  for (const Entry& entry : entries_) {
    if (entry.child) pids.push_back(entry.child->pid());
  }
  return pids;
}

std::optional<std::string> Supervisor::Lost() const {
  for (const Entry& entry : entries_) {
    if (entry.state != ProcessState::kGivenUp) continue;
    if (!entry.spec.expendable || RoleEnded(entry.spec.role)) {
      return fmt::format("{}: {}", entry.spec.name, entry.give_up_reason);
    }
  }
  return std::nullopt;
}

}  // namespace dadrl
