#include "common/liveness/stack_dump.h"

#include <execinfo.h>
#include <fmt/compile.h>
#include <fmt/format.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>

namespace dadrl {
namespace {

constexpr int kFrames = 64;

// One stack at a time. A thread that died with the turn holds up the others only until they are killed.
std::atomic_flag turn = ATOMIC_FLAG_INIT;

void WriteStack(int) {
  const int error = errno;
  while (turn.test_and_set(std::memory_order_acquire)) usleep(100);
  std::array<char, 64> head;
  const auto end =
      fmt::format_to_n(head.data(), head.size(), FMT_COMPILE("stack of thread {}:\n"), syscall(SYS_gettid));
  [[maybe_unused]] const ssize_t written = write(STDERR_FILENO, head.data(), end.size);
  std::array<void*, kFrames> frames;
  backtrace_symbols_fd(frames.data(), backtrace(frames.data(), kFrames), STDERR_FILENO);
  turn.clear(std::memory_order_release);
  errno = error;
}

}  // namespace

int StackDumpSignal() { return SIGRTMIN + 3; }

void InstallStackDump() {
  std::array<void*, 1> frame;
  backtrace(frame.data(), 1);  // the first call loads a library, which a handler may not
  struct sigaction action {};
  action.sa_handler = WriteStack;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(StackDumpSignal(), &action, nullptr);
}

}  // namespace dadrl
