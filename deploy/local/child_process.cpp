#include "deploy/local/child_process.h"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <string_view>
#include <utility>

#include "common/io/file_descriptor.h"
#include "common/io/io_error.h"
#include "common/util/environment.h"

namespace dadrl {
namespace {

// Without a descriptor that tells of the end.
constexpr Duration kPollInterval = std::chrono::milliseconds(10);
// Of a process that was killed.
constexpr Duration kLongestEnd = std::chrono::seconds(10);

// Everything the child needs, prepared before fork: after it only async-signal-safe calls are allowed.
struct ChildPlan {
  std::vector<char*> argv;
  std::vector<char*> environment;
  int null_fd;
  int out_fd;
  int error_fd;
  int report_fd;
  int beats_fd;
  int nice;
  pid_t parent;
};

[[noreturn]] void RunChild(const ChildPlan& plan) {
  const auto fail = [&]() {
    const int error = errno;
    [[maybe_unused]] const ssize_t written = write(plan.report_fd, &error, sizeof error);
    _exit(127);
  };
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGKILL);          // a host that refuses it is one of dadrl doctor's warnings
  if (getppid() != plan.parent) _exit(127);  // the launcher died before the line above took effect
  if (plan.nice != 0) setpriority(PRIO_PROCESS, 0, getpriority(PRIO_PROCESS, 0) + plan.nice);
  if (dup2(plan.null_fd, STDIN_FILENO) < 0 || dup2(plan.out_fd, STDOUT_FILENO) < 0 ||
      dup2(plan.error_fd, STDERR_FILENO) < 0) {
    fail();
  }
  // Also what the launcher itself inherited from whoever started it; best effort before Linux 5.11.
  close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC);
  if (plan.beats_fd >= 0) fcntl(plan.beats_fd, F_SETFD, 0);
  for (const int signal_number : {SIGTERM, SIGCHLD, SIGPIPE}) signal(signal_number, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  execvpe(plan.argv[0], plan.argv.data(), plan.environment.data());
  fail();
  _exit(127);
}

// Ours, with the number of the page of beats.
std::vector<std::string> EnvironmentWith(int beats_fd) {
  const std::string prefix = fmt::format("{}=", kBeatsVariable);
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    if (!std::string_view(*variable).starts_with(prefix)) variables.emplace_back(*variable);
  }
  if (beats_fd >= 0) variables.push_back(fmt::format("{}{}", prefix, beats_fd));
  return variables;
}

// As exec wants them. Borrows `words`.
std::vector<char*> Pointers(const std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (const std::string& word : words) pointers.push_back(const_cast<char*>(word.c_str()));
  pointers.push_back(nullptr);
  return pointers;
}

Result<FileDescriptor> OpenNullDevice() {
  FileDescriptor null(open("/dev/null", O_RDWR | O_CLOEXEC));
  if (!null.valid()) return tl::unexpected<Error>(IoError("open", "/dev/null", errno));
  return null;
}

}  // namespace

std::string ExitStatus::Describe() const {
  if (signaled) return fmt::format("signal {} ({})", value, strsignal(value));
  return fmt::format("exit code {}", value);
}

Result<ChildProcess> ChildProcess::Spawn(const SpawnOptions& options) {
  if (options.command.empty()) return Fail(ErrorCode::kInternal, "no command to start");
  const std::string& program = options.command.front();
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor null, OpenNullDevice());
  FileDescriptor log;
  if (!options.log.empty() && options.log_fd < 0) {
    DADRL_ASSIGN_OR_RETURN(log, FileDescriptor::Open(options.log, O_WRONLY | O_APPEND | O_CREAT));
  }
  const int log_fd = options.log_fd >= 0 ? options.log_fd : log.valid() ? log.get() : null.get();
  int report_pipe[2];
  if (pipe2(report_pipe, O_CLOEXEC) != 0) {
    return Fail(ErrorCode::kInternal, "cannot start {}: pipe: {}", program, std::strerror(errno));
  }
  const FileDescriptor report_read(report_pipe[0]);
  FileDescriptor report_write(report_pipe[1]);

  const std::vector<std::string> environment = EnvironmentWith(options.beats_fd);
  const ChildPlan plan{.argv = Pointers(options.command),
                       .environment = Pointers(environment),
                       .null_fd = null.get(),
                       .out_fd = options.stdout_fd >= 0 ? options.stdout_fd : log_fd,
                       .error_fd = log_fd,
                       .report_fd = report_write.get(),
                       .beats_fd = options.beats_fd,
                       .nice = options.nice,
                       .parent = getpid()};

  const pid_t pid = fork();
  if (pid < 0) return Fail(ErrorCode::kExhausted, "cannot start {}: fork: {}", program, std::strerror(errno));
  if (pid == 0) RunChild(plan);
  setpgid(pid, pid);  // in both processes: whoever comes first
  report_write.Close();
  int error = 0;
  ssize_t count = 0;
  do {
    count = read(report_read.get(), &error, sizeof error);
  } while (count < 0 && errno == EINTR);
  if (count == sizeof error) {
    waitpid(pid, nullptr, 0);
    return Fail(error == ENOENT ? ErrorCode::kNotFound : ErrorCode::kInternal, "cannot start {}: {}", program,
                std::strerror(error));
  }
  // glibc 2.36 declares pidfd_open without C linkage. -1 where the host refuses it.
  return ChildProcess(pid, static_cast<int>(syscall(SYS_pidfd_open, pid, 0)));
}

ChildProcess::ChildProcess(ChildProcess&& other) noexcept
    : pid_(std::exchange(other.pid_, -1)),
      pidfd_(std::exchange(other.pidfd_, -1)),
      status_(std::exchange(other.status_, std::nullopt)) {}

ChildProcess& ChildProcess::operator=(ChildProcess&& other) noexcept {
  if (this != &other) {
    Close();
    pid_ = std::exchange(other.pid_, -1);
    pidfd_ = std::exchange(other.pidfd_, -1);
    status_ = std::exchange(other.status_, std::nullopt);
  }
  return *this;
}

ChildProcess::~ChildProcess() { Close(); }

void ChildProcess::Close() {
  if (pid_ > 0 && !status_) {
    kill(-pid_, SIGKILL);
    Wait(kLongestEnd);
  }
  if (pidfd_ >= 0) close(pidfd_);
  pid_ = pidfd_ = -1;
}

void ChildProcess::Signal(int signal_number) const {
  if (pid_ > 0 && !status_) kill(-pid_, signal_number);
}

std::optional<ExitStatus> ChildProcess::TryWait() {
  if (status_ || pid_ <= 0) return status_;
  siginfo_t info{};
  const auto id = static_cast<id_t>(pid_);
  if (waitid(P_PID, id, &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == 0) return std::nullopt;
  // While the leader is a zombie its group's number cannot be taken by anybody else.
  kill(-pid_, SIGKILL);
  waitid(P_PID, id, &info, WEXITED);
  status_ = ExitStatus{.signaled = info.si_code != CLD_EXITED, .value = info.si_status};
  return status_;
}

std::optional<ExitStatus> ChildProcess::Wait(Duration timeout) {
  SystemClock clock;
  const TimePoint end = clock.Now() + timeout;
  for (Duration left = timeout; !TryWait() && left > Duration::zero(); left = end - clock.Now()) {
    const Duration wait = pidfd_ >= 0 ? left : std::min(left, kPollInterval);
    pollfd fd{.fd = pidfd_, .events = POLLIN, .revents = 0};
    poll(&fd, 1, static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(wait).count()));
  }
  return status_;
}

void BecomeSubreaper() { prctl(PR_SET_CHILD_SUBREAPER, 1); }

void ReapAdopted(const std::vector<pid_t>& owned) {
  for (;;) {
    siginfo_t info{};
    if (waitid(P_ALL, 0, &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == 0) return;
    // An owned one ended meanwhile: its owner reaps it first, the rest waits for the next call.
    if (std::find(owned.begin(), owned.end(), info.si_pid) != owned.end()) return;
    waitpid(info.si_pid, nullptr, 0);
  }
}

}  // namespace dadrl
