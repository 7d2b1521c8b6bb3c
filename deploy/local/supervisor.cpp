#include "deploy/local/supervisor.h"

#include <fcntl.h>

#include <algorithm>
#include <csignal>
#include <utility>

#include "common/io/file_descriptor.h"
#include "deploy/local/log_tail.h"

namespace dadrl {
namespace {

// Without a report, a process that stays up this long is taken to have come up.
constexpr Duration kReadyByAge = std::chrono::seconds(20);
constexpr size_t kTailLines = 8;
// For the threads of a process that hangs to write their stacks.
constexpr Duration kDumpTime = std::chrono::milliseconds(500);
// What was killed is gone at once, unless a device holds it.
constexpr Duration kKillTime = std::chrono::seconds(10);

bool IsUp(ProcessState state) { return state == ProcessState::kRunning || state == ProcessState::kStopping; }
bool WillRun(ProcessState state) { return IsUp(state) || state == ProcessState::kWaiting; }

}  // namespace

Supervisor::Supervisor(const RestartLimits& limits, const HangLimits& hang_limits, const Clock& clock,
                       Notice notice)
    : limits_(limits), hang_limits_(hang_limits), clock_(clock), notice_(std::move(notice)) {}

Status Supervisor::Start(ProcessSpec spec, bool resumed) {
  const uint64_t seed = DeriveSeed(static_cast<uint64_t>(WallTimeNs()), entries_.size());
  Entry entry{.spec = std::move(spec),
              .policy = RestartPolicy(limits_, seed),
              .child = {},
              .watch = {},
              .hung = {},
              .last_end = {},
              .give_up_reason = {}};
  DADRL_RETURN_IF_ERROR(Launch(entry, resumed));
  entries_.push_back(std::move(entry));
  return {};
}

Status Supervisor::Launch(Entry& entry, bool restart) {
  entry.started = clock_.Now();
  entry.watch = std::make_unique<LivenessWatch>(hang_limits_, entry.started);
  SpawnOptions options{.command = entry.spec.command(restart),
                       .log = entry.spec.log,
                       .nice = entry.spec.nice,
                       .beats_fd = entry.watch->page_fd()};
  const auto log = FileDescriptor::Open(options.log, O_WRONLY | O_APPEND | O_CREAT);
  if (!log && !options.log.empty()) {
    notice_(fmt::format("{}; {} runs without its log", log.error().message, entry.spec.name));
    options.log.clear();
  }
  DADRL_ASSIGN_OR_RETURN(entry.child, ChildProcess::Spawn(options));
  entry.state = ProcessState::kRunning;
  entry.killed = false;
  entry.hung.clear();
  entry.changed_ns = WallTimeNs();
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
    if (timed || !entry.hung.empty()) {
      next = std::min(next, std::max(Duration::zero(), entry.due - now));
    }
  }
  return next;
}

void Supervisor::Step() {
  for (Entry& entry : entries_) StepOne(entry);
}

void Supervisor::StepOne(Entry& entry) {
  const bool due = clock_.Now() >= entry.due;
  if (entry.child) {
    if (const auto status = entry.child->TryWait()) return OnEnded(entry, *status);
  }
  switch (entry.state) {
    case ProcessState::kRunning:
      LookForHang(entry);
      break;
    case ProcessState::kStopping:
      StepStopping(entry, due);
      break;
    case ProcessState::kWaiting:
      if (!due) break;
      if (const Status launched = Launch(entry, true); !launched) {
        notice_(launched.error().message);
        Decide(entry, Ended{.status = {.signaled = false, .value = 1}});
      }
      break;
    default:
      break;
  }
}

void Supervisor::StepStopping(Entry& entry, bool due) {
  const std::string& name = entry.spec.name;
  if (entry.killed) {
    if (!due) return;
    notice_(fmt::format("{} cannot be killed: a device holds it; it is left behind", name));
    entry.state = ProcessState::kStopped;
  } else if (due) {
    notice_(
        fmt::format("{} did not end within {:g} s and is killed", name, ToSeconds(entry.spec.stop_grace)));
    Kill(entry);
  } else if (const auto why = entry.watch->Look(entry.child->pid(), clock_.Now())) {
    notice_(fmt::format("{} hangs while it is asked to end: {}; it is killed", name, *why));
    DumpThreads(entry.child->pid(), entry.spec.log);
    Kill(entry);
  }
}

void Supervisor::LookForHang(Entry& entry) {
  const TimePoint now = clock_.Now();
  if (!entry.hung.empty()) {
    if (now >= entry.due) entry.child->Signal(SIGKILL);
    return;
  }
  const std::optional<std::string> why = entry.watch->Look(entry.child->pid(), now);
  if (!why) return;
  entry.hung = *why;
  entry.due = now + kDumpTime;
  notice_(fmt::format("{} hangs: {}; it is killed, what its threads are at is in {}", entry.spec.name, *why,
                      entry.spec.log.string()));
  DumpThreads(entry.child->pid(), entry.spec.log);
}

void Supervisor::AddPause(Duration paused) {
  for (Entry& entry : entries_) {
    if (entry.watch) entry.watch->AddPause(paused);
    // What it was given to end in is time in which it runs.
    entry.due += paused;
  }
}

void Supervisor::Kill(Entry& entry) {
  entry.state = ProcessState::kStopping;
  entry.killed = true;
  entry.due = clock_.Now() + kKillTime;
  entry.child->Signal(SIGKILL);
}

void Supervisor::OnEnded(Entry& entry, const ExitStatus& status) {
  entry.child.reset();
  entry.changed_ns = WallTimeNs();
  if (entry.state == ProcessState::kStopping || entry.state == ProcessState::kStopped) {
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
  Decide(entry, Ended{.status = status,
                      .uptime = uptime,
                      .was_ready = entry.watch->begun() || uptime >= kReadyByAge,
                      .hung = !entry.hung.empty()});
}

void Supervisor::Decide(Entry& entry, const Ended& ended) {
  const RestartDecision decision = entry.policy.OnEnd(clock_.Now(), ended);
  if (ended.hung) {
    ++entry.hangs;
    entry.last_end = fmt::format("it hung: {}", entry.hung);
    entry.hung.clear();
  } else {
    entry.last_end = fmt::format("it ended with {}", ended.status.Describe());
  }
  if (const auto* restart = std::get_if<RestartAfter>(&decision)) {
    ++entry.restarts;
    entry.state = ProcessState::kWaiting;
    entry.due = clock_.Now() + restart->delay;
    notice_(fmt::format("{}: {}; starting it again in {:.1f} s", entry.spec.name, entry.last_end,
                        ToSeconds(restart->delay)));
    return;
  }
  entry.state = ProcessState::kGivenUp;
  entry.give_up_reason = std::get<GiveUp>(decision).reason;
  notice_(WithLogTail(entry, fmt::format("{}: {}; not started again: {}", entry.spec.name, entry.last_end,
                                         entry.give_up_reason)));
}

std::string Supervisor::WithLogTail(const Entry& entry, std::string text) const {
  if (entry.spec.log.empty()) return text;
  text += fmt::format("; the end of {}:", entry.spec.log.string());
  for (const std::string& line : LogTail(entry.spec.log, kTailLines)) text += "\n  | " + line;
  return text;
}

void Supervisor::StopRole(std::string_view role) {
  for (Entry& entry : entries_) {
    if (entry.spec.role != role) continue;
    if (entry.state == ProcessState::kWaiting) entry.state = ProcessState::kStopped;
    if (entry.state != ProcessState::kRunning) continue;
    if (!entry.hung.empty()) {
      Kill(entry);  // nobody is there to be asked
      continue;
    }
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
  return std::count_if(entries_.begin(), entries_.end(),
                       [&](const Entry& entry) { return entry.spec.role == role && entry.state == state; });
}

std::vector<pid_t> Supervisor::RunningPids() const {
  std::vector<pid_t> pids;
  for (const Entry& entry : entries_) {
    if (entry.child) pids.push_back(entry.child->pid());
  }
  return pids;
}

bool Supervisor::Expendable(const Entry& entry) const {
  if (!entry.spec.expendable) return false;
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& other) {
    return &other != &entry && other.spec.role == entry.spec.role && WillRun(other.state);
  });
}

std::optional<std::string> Supervisor::Lost() const {
  for (const Entry& entry : entries_) {
    if (entry.state != ProcessState::kGivenUp || Expendable(entry)) continue;
    return fmt::format("{}: {}", entry.spec.name, entry.give_up_reason);
  }
  return std::nullopt;
}

}  // namespace dadrl
