// A command's signals as something to poll: blocked for every thread, looked for when it suits.
#pragma once

#include <sys/types.h>

#include <csignal>
#include <functional>
#include <memory>
#include <vector>

#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// Create on the main thread before any other thread starts (threads inherit the mask). Children started by
// ChildProcess get a clean mask. A signal that was ignored when the program started (nohup, a shell's
// background job) stays ignored. Not thread safe.
class SignalWatcher {
 public:
  // Blocks SIGINT, SIGTERM, SIGHUP, SIGTSTP and SIGCHLD; ignores SIGPIPE.
  static Result<std::unique_ptr<SignalWatcher>> Create();
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

  // Readable when a signal came: for poll(), which ignores the -1 of a host without signalfd: ask several
  // times a second as well.
  int fd() const { return fd_; }
  // These take in what came and never block.
  // Somebody wants an end: SIGINT, SIGTERM or SIGHUP came.
  bool StopRequested();
  // A user wants it now: SIGINT came twice. (A closed terminal may send SIGHUP more than once.)
  bool KillRequested();
  // A user wants a pause (Ctrl-Z): SIGTSTP came since the last PauseWith.
  bool PauseRequested();

  // Stops the process groups that `children` lead and then this process, as Ctrl-Z does. When this process is
  // continued (fg, SIGCONT), `continued` is told how long that took, and then the children go on.
  void PauseWith(const std::vector<pid_t>& children, const std::function<void(Duration)>& continued = {});

 private:
  SignalWatcher(const sigset_t& watched, int fd) : watched_(watched), fd_(fd) {}
  void Read();

  const sigset_t watched_;
  const int fd_;
  bool stop_requested_ = false;
  bool pause_requested_ = false;
  int interrupts_ = 0;
};

}  // namespace dadrl
