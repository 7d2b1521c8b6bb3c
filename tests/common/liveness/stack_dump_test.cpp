#include "common/liveness/stack_dump.h"

#include <gmock/gmock.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <thread>

namespace dadrl {
namespace {

TEST(StackDump, WritesTheStackOfTheThreadThatIsAskedAndLetsItGoOn) {
  InstallStackDump();
  std::atomic<pid_t> id{0};
  std::atomic<bool> stop{false};
  std::thread thread([&] {
    id = gettid();
    while (!stop) usleep(1000);
  });
  while (id == 0) usleep(1000);
  testing::internal::CaptureStderr();
  // To both at once: one stack after the other.
  syscall(SYS_tgkill, getpid(), id.load(), StackDumpSignal());
  syscall(SYS_tgkill, getpid(), gettid(), StackDumpSignal());
  stop = true;
  thread.join();
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_THAT(text, testing::HasSubstr("stack of thread " + std::to_string(id) + ":\n"));
  EXPECT_THAT(text, testing::HasSubstr("stack of thread " + std::to_string(gettid()) + ":\n"));
  EXPECT_THAT(text, testing::HasSubstr("liveness_test"));
}

}  // namespace
}  // namespace dadrl
