// Keeps a set of processes alive: starts them, starts them again after a crash or when they hang, stops them
// in order.
#pragma once

#include <poll.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/clock.h"
#include "common/util/result.h"
#include "deploy/local/child_process.h"
#include "deploy/local/liveness_watch.h"
#include "deploy/local/restart_policy.h"
#include "deploy/monitor/supervision.h"

namespace dadrl {

struct ProcessSpec {
  std::string name;  // "actor-0": in messages
  std::string role;  // "actor": processes that are stopped together
  // The command line; `restart` is true from the second start on (and the first one of a resumed run).
  std::function<std::vector<std::string>(bool restart)> command;
  std::filesystem::path log;
  int nice = 0;
  bool may_finish = false;  // exit code 0 is the end of its work, not a failure
  bool expendable = false;  // given up, it can be done without while another of its role lives
  Duration stop_grace = std::chrono::seconds(15);  // from SIGTERM to SIGKILL
};

enum class ProcessState {
  kRunning,
  kWaiting,   // ended, will be started again
  kStopping,  // was sent SIGTERM
  kStopped,   // ended as asked
  kFinished,  // ended by itself with its work done (may_finish)
  kGivenUp,
};

// Not thread safe; all calls on the one thread that lives as long as the children. Nothing here blocks:
// the owner polls AppendWaitFds and calls Step, several times a second. Processes beat on a page that they
// inherit (common/liveness); one that hangs (HangWatch) is said, its threads are written to its log, and it
// is killed and started again.
class Supervisor {
 public:
  // `notice` gets one line (or a few, with a log's end) about what happened; called from Step, Start and
  // Stop.
  using Notice = std::function<void(const std::string& text)>;
  Supervisor(const RestartLimits& limits, const HangLimits& hang_limits, const Clock& clock, Notice notice);

  // Starts it now; `resumed` is passed on to its command. A command that cannot be executed at all is an
  // error.
  Status Start(ProcessSpec spec, bool resumed = false);

  // Descriptors that become readable when a child ends.
  void AppendWaitFds(std::vector<pollfd>& fds) const;
  // Until the next restart or kill is due; at most `limit`.
  Duration NextDeadline(Duration limit) const;
  // Reaps, restarts, kills what hangs or outstayed its grace.
  void Step();
  // All processes were kept stopped for so long (Ctrl-Z).
  void AddPause(Duration paused);

  // Asks every process of `role` to end; those waiting for a restart just do not come back.
  void StopRole(std::string_view role);
  // Kills everything at once; the next Steps reap it.
  void KillAll();

  // True when no process of `role` runs or will run again.
  bool RoleEnded(std::string_view role) const;
  bool AllEnded() const;
  // How many of `role` are in `state`.
  int Count(std::string_view role, ProcessState state) const;
  // Pids of what runs, for ReapAdopted.
  std::vector<pid_t> RunningPids() const;
  // The process that was given up and cannot be done without, with the reason.
  std::optional<std::string> Lost() const;
  // What there is to know of each process.
  Supervision Describe() const;
  // What the processes of `role` say that they came to (common/liveness/working_thread.h), in sum.
  uint64_t Work(std::string_view role) const;

 private:
  struct Entry {
    ProcessSpec spec;
    RestartPolicy policy;
    ProcessState state = ProcessState::kRunning;
    std::optional<ChildProcess> child;
    std::unique_ptr<LivenessWatch> watch;  // of this start
    TimePoint started{};
    int64_t changed_ns = 0;  // wall time of its last start or end
    std::string hung;        // why it is about to be killed
    bool killed = false;     // by us, and not to be started again
    TimePoint due{};         // of the restart (kWaiting) or the kill (kStopping unless killed, and when hung)
    int restarts = 0;
    int hangs = 0;
    std::string last_end;
    std::string give_up_reason;
  };

  Status Launch(Entry& entry, bool restart);
  void StepOne(Entry& entry);
  void StepStopping(Entry& entry, bool due);
  void LookForHang(Entry& entry);
  void Kill(Entry& entry);
  void OnEnded(Entry& entry, const ExitStatus& status);
  void Decide(Entry& entry, const Ended& ended);
  std::string WithLogTail(const Entry& entry, std::string text) const;
  bool Expendable(const Entry& entry) const;
  SupervisedProcess Describe(const Entry& entry) const;

  RestartLimits limits_;
  HangLimits hang_limits_;
  const Clock& clock_;
  Notice notice_;
  std::vector<Entry> entries_;
};

}  // namespace dadrl
