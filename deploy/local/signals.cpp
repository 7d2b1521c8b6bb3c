#include "deploy/local/signals.h"

#include <sys/signalfd.h>
#include <unistd.h>

namespace dadrl {
namespace {

bool IsIgnored(int signal_number) {
  struct sigaction action {};
  return sigaction(signal_number, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

sigset_t Watched() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGCHLD);
  for (const int signal_number : {SIGINT, SIGTERM, SIGHUP, SIGTSTP}) {
    if (!IsIgnored(signal_number)) sigaddset(&set, signal_number);
  }
  return set;
}

void SignalGroups(const std::vector<pid_t>& leaders, int signal_number) {
  for (const pid_t leader : leaders) kill(-leader, signal_number);
}

}  // namespace

Result<std::unique_ptr<SignalWatcher>> SignalWatcher::Create() {
  const sigset_t watched = Watched();
  pthread_sigmask(SIG_BLOCK, &watched, nullptr);
  signal(SIGPIPE, SIG_IGN);
  return std::unique_ptr<SignalWatcher>(
      new SignalWatcher(watched, signalfd(-1, &watched, SFD_NONBLOCK | SFD_CLOEXEC)));
}

SignalWatcher::~SignalWatcher() {
  if (fd_ >= 0) close(fd_);
  pthread_sigmask(SIG_UNBLOCK, &watched_, nullptr);
}

void SignalWatcher::Read() {
  constexpr timespec kNow{};
  for (int came = 0; (came = sigtimedwait(&watched_, nullptr, &kNow)) > 0;) {
    if (came == SIGTSTP) {
      pause_requested_ = true;
    } else if (came != SIGCHLD) {
      stop_requested_ = true;
    }
    interrupts_ += came == SIGINT ? 1 : 0;
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

bool SignalWatcher::PauseRequested() {
  Read();
  return pause_requested_;
}

void SignalWatcher::PauseWith(const std::vector<pid_t>& children,
                              const std::function<void(Duration)>& continued) {
  const SystemClock clock;
  const TimePoint began = clock.Now();
  pause_requested_ = false;
  SignalGroups(children, SIGSTOP);
  // By its own signal, so that a shell sees what it expects; where no shell could continue us it does
  // nothing.
  sigset_t pause;
  sigemptyset(&pause);
  sigaddset(&pause, SIGTSTP);
  raise(SIGTSTP);
  pthread_sigmask(SIG_UNBLOCK, &pause, nullptr);  // here it stops
  pthread_sigmask(SIG_BLOCK, &pause, nullptr);
  if (continued) continued(clock.Now() - began);
  SignalGroups(children, SIGCONT);
}

}  // namespace dadrl
