#include "deploy/local/system_call_checks.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <csignal>

#include "common/io/unnamed_file.h"
#include "deploy/local/thread_times.h"

namespace dadrl {
namespace {

bool Opens(long fd) {
  const FileDescriptor file(static_cast<int>(fd));
  return file.valid();
}

bool OpensSignals() {
  sigset_t none;
  sigemptyset(&none);
  return Opens(signalfd(-1, &none, SFD_CLOEXEC));
}

bool LocksOpenFiles() {
  const auto file = OpenUnnamedFile("lock");
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return file && fcntl(file->get(), F_OFD_SETLK, &lock) == 0;
}

bool KeepsAdopting() {
  int adopts = 0;
  return prctl(PR_GET_CHILD_SUBREAPER, &adopts) == 0 && prctl(PR_SET_CHILD_SUBREAPER, adopts) == 0;
}

bool KeepsDeathSignal() {
  int signal_number = 0;
  return prctl(PR_GET_PDEATHSIG, &signal_number) == 0 && prctl(PR_SET_PDEATHSIG, signal_number) == 0;
}

bool SeesThreads() {
  const auto threads = ReadThreadTimes(getpid());
  return !threads.empty() && threads.front().ran > Duration::zero();
}

}  // namespace

MachineCheck CheckSystemCalls() {
  std::vector<std::string> refused;
  const auto check = [&](bool works, const char* call, const char* consequence) {
    if (!works) refused.push_back(fmt::format("{} ({})", call, consequence));
  };
  check(Opens(memfd_create("probe", MFD_CLOEXEC)), "memfd_create", "files in /dev/shm or TMPDIR stand in");
  check(Opens(syscall(SYS_pidfd_open, getpid(), 0)), "pidfd_open", "an end is noticed within 0.2 s");
  check(OpensSignals(), "signalfd", "a signal is noticed within 0.2 s");
  check(KeepsDeathSignal(), "PR_SET_PDEATHSIG", "processes outlive a launcher that is killed");
  check(KeepsAdopting(), "PR_SET_CHILD_SUBREAPER", "what they start outlives them");
  check(LocksOpenFiles(), "F_OFD_SETLK", "a run directory cannot be locked");
  check(SeesThreads(), "/proc/PID/task",
        "a busy machine may be taken for a hang: raise cluster.liveliness_s");
  if (refused.empty()) return {"system calls", CheckState::kGood, "all there", ""};
  return {"system calls", CheckState::kWarning, fmt::format("refused: {}", fmt::join(refused, ", ")),
          "another seccomp profile of the container, or a newer kernel"};
}

}  // namespace dadrl
