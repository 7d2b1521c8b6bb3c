// One child process of the launcher: started by fork and exec, watched, never left behind.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// How a process ended.
struct ExitStatus {
  bool signaled = false;
  int value = 0;  // exit code, or signal number when `signaled`

  bool success() const { return !signaled && value == 0; }
  // "exit code 1", "signal 9 (Killed)".
  std::string Describe() const;
};

struct SpawnOptions {
  std::vector<std::string> command;  // command[0] is the executable's path; PATH is searched if it has no '/'
  std::filesystem::path log;         // standard output and error are appended; empty: both are discarded
  int stdout_fd = -1;                // >= 0: standard output goes to this open descriptor, borrowed
  int log_fd = -1;                   // >= 0: instead of `log`, borrowed
  int nice = 0;                      // added to the child's niceness
  int beats_fd = -1;  // >= 0: the page on which it beats (common/liveness/beat_page.h), borrowed
};

// Owns the process: the destructor kills and reaps what still runs; one that a device holds so that even
// SIGKILL does not end it is left behind after some seconds. Not thread safe. Spawn on a thread that lives as
// long as the child: the kernel kills the child (PR_SET_PDEATHSIG, where the host allows it) when that thread
// ends, however it ends.
//
// The child leads its own process group, so a terminal's Ctrl-C and Ctrl-Z reach the launcher alone, and
// stopping it takes its descendants along. SIGINT and SIGHUP stay ignored if they were when this process
// started (nohup); SIGTERM, by which it is asked to end, never is.
class ChildProcess {
 public:
  // Returns once the program image was replaced; kNotFound or kInternal when it could not be.
  static Result<ChildProcess> Spawn(const SpawnOptions& options);

  ChildProcess(ChildProcess&& other) noexcept;
  ChildProcess& operator=(ChildProcess&& other) noexcept;
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;
  ~ChildProcess();

  pid_t pid() const { return pid_; }
  // Readable when the process has ended: for poll(), which ignores the -1 of a host without pidfd_open: look
  // at TryWait several times a second as well.
  int pidfd() const { return pidfd_; }

  // Sends `signal_number` to the process and its group; harmless after it has ended.
  void Signal(int signal_number) const;

  // Never blocks. Once the process has ended: kills what is left of its group, reaps it, returns its status
  // (the same again on later calls).
  std::optional<ExitStatus> TryWait();
  // The same, but waits for the end, at most `timeout`.
  std::optional<ExitStatus> Wait(Duration timeout);

 private:
  ChildProcess(pid_t pid, int pidfd) : pid_(pid), pidfd_(pidfd) {}
  void Close();

  pid_t pid_ = -1;
  int pidfd_ = -1;
  std::optional<ExitStatus> status_;
};

// Makes this process adopt orphaned descendants, so that a grandchild whose parent died is reaped here.
void BecomeSubreaper();

// Reaps ended children that no ChildProcess of this process owns (adopted grandchildren); never blocks.
// `owned`: pids that ChildProcess objects will reap themselves.
void ReapAdopted(const std::vector<pid_t>& owned);

}  // namespace dadrl
