// The launcher's signals as something to poll: blocked for every thread, read from one descriptor.
#pragma once

#include <memory>

#include "common/util/result.h"

namespace dadrl {

// Create on the main thread before any other thread starts (threads inherit the mask). Children started by
// ChildProcess get a clean mask. Not thread safe.
class SignalWatcher {
 public:
  // Blocks SIGINT, SIGTERM, SIGHUP and SIGCHLD; ignores SIGPIPE.
  static Result<std::unique_ptr<SignalWatcher>> Create();
  ~SignalWatcher();
  SignalWatcher(const SignalWatcher&) = delete;
  SignalWatcher& operator=(const SignalWatcher&) = delete;

  int fd() const { return fd_; }
  // Both read what arrived and never block.
  // Somebody wants an end: SIGINT, SIGTERM or SIGHUP came.
  bool StopRequested();
  // A user wants it now: SIGINT came twice. (A closed terminal may send SIGHUP more than once.)
  bool KillRequested();

 private:
  explicit SignalWatcher(int fd) : fd_(fd) {}
  int fd_;
  void Read();
  bool stop_requested_ = false;
  int interrupts_ = 0;
};

}  // namespace dadrl
