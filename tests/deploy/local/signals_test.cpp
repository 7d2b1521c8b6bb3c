#include "deploy/local/signals.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/util/shutdown.h"
#include "deploy/local/child_process.h"
#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

// Runs `body` in a process of its own, since signals belong to a process. Its exit code.
int InProcess(const std::function<bool()>& body) {
  const pid_t pid = fork();
  if (pid == 0) _exit(body() ? 0 : 1);
  int status = 0;
  waitpid(pid, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(SignalWatcher, TellsWhatCame) {
  EXPECT_EQ(InProcess([] {
              const auto signals = SignalWatcher::Create().value();
              const bool before = signals->StopRequested() || signals->PauseRequested();
              kill(getpid(), SIGCHLD);
              kill(getpid(), SIGTSTP);
              const bool paused = signals->PauseRequested() && !signals->StopRequested();
              kill(getpid(), SIGINT);
              const bool stopped = signals->StopRequested() && !signals->KillRequested();
              kill(getpid(), SIGINT);
              return !before && paused && stopped && signals->KillRequested();
            }),
            0);
}

TEST(SignalWatcher, LeavesIgnoredWhatWasIgnoredAtStart) {
  for (const int ignored : {SIGHUP, SIGINT, SIGTERM}) {
    EXPECT_EQ(InProcess([&] {
                signal(ignored, SIG_IGN);
                const auto signals = SignalWatcher::Create().value();
                kill(getpid(), ignored);
                const bool left_alone = !signals->StopRequested();
                kill(getpid(), ignored == SIGTERM ? SIGHUP : SIGTERM);
                return left_alone && signals->StopRequested();
              }),
              0)
        << ignored;
  }
}

TEST(ShutdownHandler, LeavesIgnoredWhatWasIgnoredAtStart) {
  EXPECT_EQ(InProcess([] {
              signal(SIGHUP, SIG_IGN);
              InstallShutdownHandler();
              kill(getpid(), SIGHUP);
              const bool left_alone = !shutdown_requested;
              kill(getpid(), SIGTERM);
              return left_alone && shutdown_requested;
            }),
            0);
  EXPECT_EQ(InProcess([] {
              InstallShutdownHandler();
              kill(getpid(), SIGHUP);
              return shutdown_requested.load();
            }),
            0);
}

TEST(SignalWatcher, PausesWithItsChildrenAndGoesOnWithThem) {
  // A launcher with a group of its own, as a shell starts it, and a child in another.
  const pid_t launcher = fork();
  if (launcher == 0) {
    setpgid(0, 0);
    const auto signals = SignalWatcher::Create().value();
    auto child = ChildProcess::Spawn({.command = {"sleep", "1000"}, .log = {}});
    kill(getpid(), SIGTSTP);
    if (!child || !signals->PauseRequested()) _exit(1);
    bool child_waited = false;
    signals->PauseWith({child->pid()}, [&](Duration paused) {
      child_waited = paused > Duration::zero() && IsStopped(child->pid());
    });
    const bool goes_on = child_waited && Eventually([&] { return !IsStopped(child->pid()); });
    child->Signal(SIGKILL);
    _exit(goes_on ? 0 : 2);
  }
  ASSERT_TRUE(Eventually([&] { return IsStopped(launcher); }));
  const pid_t child = ChildOf(launcher);
  ASSERT_TRUE(Eventually([&] { return IsStopped(child); }));
  kill(launcher, SIGCONT);
  int status = 0;
  waitpid(launcher, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace dadrl
