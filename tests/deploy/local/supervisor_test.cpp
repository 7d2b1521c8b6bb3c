#include "deploy/local/supervisor.h"

#include <gmock/gmock.h>
#include <signal.h>

#include "tests/deploy/local/test_processes.h"

namespace dadrl {
namespace {

using ::testing::AnyOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

// Real children, real time, delays of milliseconds.
class SupervisorTest : public testing::Test {
 protected:
  SupervisorTest()
      : supervisor_(Limits(), HangLimits{}, clock_,
                    [this](const std::string& text) { notices_.push_back(text); }) {}

  static RestartLimits Limits() {
    RestartLimits limits;
    limits.first_delay = std::chrono::milliseconds(10);
    limits.max_delay = std::chrono::milliseconds(50);
    return limits;
  }

  ProcessSpec Script(const std::string& name, const std::string& role, const std::string& script) {
    ProcessSpec spec;
    spec.name = name;
    spec.role = role;
    spec.command = [script](bool restart) {
      return std::vector<std::string>{"/bin/sh", "-c", script, "sh", restart ? "restart" : "first"};
    };
    spec.log = folder_.path() / (name + ".log");
    return spec;
  }

  std::filesystem::path File(const std::string& name) { return folder_.path() / name; }

  bool StepUntil(const std::function<bool()>& condition) {
    return Eventually([&] {
      supervisor_.Step();
      return condition();
    });
  }

  TemporaryFolder folder_;
  SystemClock clock_;
  std::vector<std::string> notices_;
  Supervisor supervisor_;
};

// Writes its pid once the trap is set.
std::string Server(const std::filesystem::path& pid_file) {
  return "trap 'exit 0' TERM; echo $$ > " + pid_file.string() + "; while :; do sleep 0.01; done";
}

TEST_F(SupervisorTest, RestartsAKilledProcessAndTellsItSo) {
  ASSERT_TRUE(supervisor_.Start(Script("actor-0", "actor", "echo $1; " + Server(File("pid")))));
  ASSERT_TRUE(StepUntil([&] { return PidIn(File("pid")) > 0; }));
  const pid_t first = PidIn(File("pid"));
  kill(first, SIGKILL);
  ASSERT_TRUE(StepUntil([&] { return PidIn(File("pid")) != first && PidIn(File("pid")) > 0; }));
  EXPECT_EQ(supervisor_.Count("actor", ProcessState::kRunning), 1);
  EXPECT_EQ(FileText(File("actor-0.log")), "first\nrestart\n");
  EXPECT_THAT(notices_, Contains(HasSubstr("actor-0: it ended with signal 9")));
}

TEST_F(SupervisorTest, StopsOneRoleAndLeavesTheOthers) {
  ASSERT_TRUE(supervisor_.Start(Script("actor-0", "actor", Server(File("a0")))));
  ASSERT_TRUE(supervisor_.Start(Script("actor-1", "actor", Server(File("a1")))));
  ASSERT_TRUE(supervisor_.Start(Script("replay-0", "replay", Server(File("r0")))));
  ASSERT_TRUE(
      StepUntil([&] { return PidIn(File("a0")) > 0 && PidIn(File("a1")) > 0 && PidIn(File("r0")) > 0; }));
  supervisor_.StopRole("actor");
  ASSERT_TRUE(StepUntil([&] { return supervisor_.RoleEnded("actor"); }));
  EXPECT_EQ(supervisor_.Count("actor", ProcessState::kStopped), 2);
  EXPECT_EQ(supervisor_.Count("replay", ProcessState::kRunning), 1);
  EXPECT_THAT(notices_, IsEmpty());
  EXPECT_FALSE(supervisor_.AllEnded());
  supervisor_.StopRole("replay");
  EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
}

TEST_F(SupervisorTest, KillsWhatOutstaysItsGrace) {
  ProcessSpec spec =
      Script("learner", "learner",
             "trap '' TERM; echo $$ > " + File("pid").string() + "; while :; do sleep 0.01; done");
  spec.stop_grace = std::chrono::milliseconds(50);
  ASSERT_TRUE(supervisor_.Start(std::move(spec)));
  ASSERT_TRUE(StepUntil([&] { return PidIn(File("pid")) > 0; }));
  supervisor_.StopRole("learner");
  EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
  EXPECT_THAT(notices_, Contains(HasSubstr("learner did not end within 0.05 s and is killed")));
}

TEST_F(SupervisorTest, GivesUpOnWhatNeverComesUpAndShowsItsLog) {
  ASSERT_TRUE(supervisor_.Start(Script("replay-0", "replay", "echo port 7400 is taken >&2; exit 1")));
  ASSERT_TRUE(StepUntil([&] { return supervisor_.Lost().has_value(); }));
  EXPECT_EQ(*supervisor_.Lost(), "replay-0: it failed 4 times before it was ready");
  EXPECT_THAT(notices_.back(), HasSubstr("| port 7400 is taken"));
  EXPECT_TRUE(supervisor_.AllEnded());
}

TEST_F(SupervisorTest, GivesUpAtOnceOnWrongUsage) {
  ASSERT_TRUE(supervisor_.Start(Script("actor-0", "actor", "exit 2")));
  ASSERT_TRUE(StepUntil([&] { return supervisor_.Lost().has_value(); }));
  EXPECT_EQ(notices_.size(), 1u);
}

TEST_F(SupervisorTest, AnExpendableProcessIsNotMissedWhileAnotherLives) {
  for (const char* name : {"actor-0", "actor-1"}) {
    ProcessSpec spec = Script(name, "actor", name == std::string("actor-0") ? "exit 2" : Server(File("a1")));
    spec.expendable = true;
    ASSERT_TRUE(supervisor_.Start(std::move(spec)));
  }
  ASSERT_TRUE(StepUntil([&] { return supervisor_.Count("actor", ProcessState::kGivenUp) == 1; }));
  EXPECT_FALSE(supervisor_.Lost());
  supervisor_.KillAll();
  EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
}

TEST_F(SupervisorTest, FinishedWorkIsNotRestarted) {
  ProcessSpec learner = Script("learner", "learner", "exit 0");
  learner.may_finish = true;
  ASSERT_TRUE(supervisor_.Start(std::move(learner)));
  ASSERT_TRUE(supervisor_.Start(Script("replay-0", "replay", Server(File("r0")))));
  ASSERT_TRUE(StepUntil([&] { return supervisor_.Count("learner", ProcessState::kFinished) == 1; }));
  EXPECT_EQ(supervisor_.Count("replay", ProcessState::kRunning), 1);
  supervisor_.KillAll();
  EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
  EXPECT_THAT(notices_, IsEmpty());  // neither the finish nor our own kill is news
}

TEST_F(SupervisorTest, AServiceThatEndsUnaskedIsStartedAgainEvenAfterExitCodeZero) {
  ASSERT_TRUE(supervisor_.Start(Script("replay-0", "replay", "[ $1 = restart ] && exec sleep 1000; exit 0")));
  ASSERT_TRUE(StepUntil([&] { return !notices_.empty(); }));
  EXPECT_TRUE(StepUntil([&] { return supervisor_.Count("replay", ProcessState::kRunning) == 1; }));
  supervisor_.KillAll();
  EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
}

TEST_F(SupervisorTest, StoppingCancelsAPendingRestart) {
  RestartLimits slow = Limits();
  slow.first_delay = slow.max_delay = std::chrono::hours(1);
  Supervisor supervisor(slow, HangLimits{}, clock_,
                        [this](const std::string& text) { notices_.push_back(text); });
  ASSERT_TRUE(supervisor.Start(Script("actor-0", "actor", "exit 1")));
  ASSERT_TRUE(Eventually([&] {
    supervisor.Step();
    return supervisor.Count("actor", ProcessState::kWaiting) == 1;
  }));
  EXPECT_GT(supervisor.NextDeadline(std::chrono::hours(5)), std::chrono::minutes(50));
  supervisor.StopRole("actor");
  EXPECT_TRUE(supervisor.AllEnded());
}

TEST_F(SupervisorTest, RefusesToStartAMissingExecutable) {
  ProcessSpec spec = Script("actor-0", "actor", "");
  spec.command = [](bool) { return std::vector<std::string>{"/no/such/dadrl-actor"}; };
  const Status status = supervisor_.Start(std::move(spec));
  ASSERT_FALSE(status);
  EXPECT_THAT(status.error().message, HasSubstr("/no/such/dadrl-actor"));
  EXPECT_TRUE(supervisor_.AllEnded());
}

}  // namespace
}  // namespace dadrl
