#include "deploy/local/signals.h"

#include <pthread.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>

namespace dadrl {
namespace {

sigset_t Watched() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP, SIGCHLD}) sigaddset(&set, signal_number);
  return set;
}

}  // namespace

Result<std::unique_ptr<SignalWatcher>> SignalWatcher::Create() {
  const sigset_t set = Watched();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signal(SIGPIPE, SIG_IGN);
  const int fd = signalfd(-1, &set, SFD_NONBLOCK | SFD_CLOEXEC);
  if (fd < 0) return Fail(ErrorCode::kInternal, "signalfd: {}", std::strerror(errno));
  return std::unique_ptr<SignalWatcher>(new SignalWatcher(fd));
}

SignalWatcher::~SignalWatcher() {
  close(fd_);
  const sigset_t set = Watched();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void SignalWatcher::Read() {
  signalfd_siginfo info;
  while (read(fd_, &info, sizeof info) == sizeof info) {
    stop_requested_ = stop_requested_ || info.ssi_signo != SIGCHLD;
    interrupts_ += info.ssi_signo == SIGINT ? 1 : 0;
  }
}

bool SignalWatcher::StopRequested() {
  Read();
  return stop_requested_;
}

bool SignalWatcher::KillRequested() {
  Read();
  return interrupts_ > 1;
}

}  // namespace dadrl
