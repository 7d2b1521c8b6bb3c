#include "deploy/local/child_process.h"

#include <gmock/gmock.h>
#include <poll.h>
#include <sys/wait.h>

#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

ExitStatus WaitFor(ChildProcess& child) {
  pollfd fd{.fd = child.pidfd(), .events = POLLIN, .revents = 0};
  EXPECT_EQ(poll(&fd, 1, 20000), 1);
  const auto status = child.TryWait();
  EXPECT_TRUE(status.has_value());
  return status.value_or(ExitStatus{});
}

Result<ChildProcess> Shell(const std::string& script, const std::filesystem::path& log = {}) {
  return ChildProcess::Spawn({.command = {"/bin/sh", "-c", script}, .log = log});
}

TEST(ChildProcess, ReportsExitCodeAndSignal) {
  auto exits = Shell("exit 7");
  ASSERT_TRUE(exits);
  EXPECT_EQ(WaitFor(*exits).Describe(), "exit code 7");
  EXPECT_EQ(exits->TryWait()->value, 7);  // the same again
  auto dies = Shell("kill -SEGV $$");
  ASSERT_TRUE(dies);
  const ExitStatus status = WaitFor(*dies);
  EXPECT_TRUE(status.signaled);
  EXPECT_THAT(status.Describe(), HasSubstr("signal 11"));
}

TEST(ChildProcess, RefusesWhatCannotBeExecuted) {
  const auto missing = ChildProcess::Spawn({.command = {"/no/such/program"}, .log = {}});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, ErrorCode::kNotFound);
  EXPECT_THAT(missing.error().message, HasSubstr("/no/such/program"));
  EXPECT_FALSE(ChildProcess::Spawn({.command = {}, .log = {}}));
}

TEST(ChildProcess, AppendsBothStreamsToTheLog) {
  const TemporaryFolder folder;
  const auto log = folder.path() / "child.log";
  for (int i = 0; i < 2; ++i) {
    auto child = Shell("echo out; echo err >&2", log);
    ASSERT_TRUE(child);
    WaitFor(*child);
  }
  EXPECT_EQ(FileText(log), "out\nerr\nout\nerr\n");
}

TEST(ChildProcess, InheritsNoDescriptorsAndNoBlockedSignals) {
  const TemporaryFolder folder;
  const auto log = folder.path() / "child.log";
  sigset_t block;
  sigset_t before;
  sigemptyset(&block);
  sigaddset(&block, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &block, &before);
  auto child = Shell("ls /proc/self/fd | wc -l; grep SigBlk /proc/self/status", log);
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ASSERT_TRUE(child);
  WaitFor(*child);
  // 0, 1, 2 and the one with which ls reads the folder.
  EXPECT_EQ(FileText(log), "4\nSigBlk:\t0000000000000000\n");
}

TEST(ChildProcess, DestructorTakesDescendantsAlong) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "pid";
  pid_t child_pid = 0;
  {
    auto child = Shell("sleep 1000 & echo $! > " + file.string() + "; wait");
    ASSERT_TRUE(child);
    child_pid = child->pid();
    ASSERT_TRUE(Eventually([&] { return PidIn(file) > 0; }));
  }
  EXPECT_TRUE(IsDead(child_pid));
  EXPECT_TRUE(Eventually([&] { return IsDead(PidIn(file)); }));
}

TEST(ChildProcess, EndOfTheLeaderTakesItsGroupAlong) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "pid";
  auto child = Shell("sleep 1000 & echo $! > " + file.string());
  ASSERT_TRUE(child);
  WaitFor(*child);
  EXPECT_TRUE(Eventually([&] { return IsDead(PidIn(file)); }));
}

TEST(ChildProcess, DiesWithItsLauncher) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "pid";
  const pid_t launcher = fork();
  if (launcher == 0) {
    auto child = Shell("echo $$ > " + file.string() + "; exec sleep 1000");
    pause();
    _exit(0);
  }
  ASSERT_TRUE(Eventually([&] { return PidIn(file) > 0; }));
  kill(launcher, SIGKILL);
  waitpid(launcher, nullptr, 0);
  EXPECT_TRUE(Eventually([&] { return IsDead(PidIn(file)); }));
}

TEST(ChildProcess, WritesStandardOutputToAGivenDescriptor) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "out";
  std::FILE* stream = std::fopen(file.c_str(), "we");
  auto child = ChildProcess::Spawn(
      {.command = {"/bin/sh", "-c", "echo result; echo noise >&2"}, .log = {}, .stdout_fd = fileno(stream)});
  ASSERT_TRUE(child);
  WaitFor(*child);
  std::fclose(stream);
  EXPECT_EQ(FileText(file), "result\n");
}

}  // namespace
}  // namespace dadrl
