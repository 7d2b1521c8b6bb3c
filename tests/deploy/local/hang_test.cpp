// Hangs of real processes: the supervisor's, and an evaluation's workers.
#include <gmock/gmock.h>
#include <signal.h>

#include "deploy/local/captured_process.h"
#include "deploy/local/supervisor.h"
#include "tests/deploy/local/test_processes.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

class HangTest : public testing::Test {
 protected:
  HangTest()
      : supervisor_({.first_delay = 10ms}, {.silent = 500ms, .spinning = 60s, .unborn = 60s}, clock_,
                    [this](const std::string& text) { notices_.push_back(text); }) {}

  ~HangTest() override {
    supervisor_.KillAll();
    EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
  }

  Status Start(const std::string& name, const std::string& mode) {
    ProcessSpec spec;
    spec.name = name;
    spec.role = name.substr(0, name.find('-'));
    spec.log = folder_.path() / (name + ".log");
    spec.command = [this, name, mode](bool restart) {
      return std::vector<std::string>{DADRL_BINARY_DIR "/tests/test_worker", restart ? "beat" : mode,
                                      File(name)};
    };
    return supervisor_.Start(std::move(spec));
  }

  std::filesystem::path File(const std::string& name) { return folder_.path() / name; }

  bool StepUntil(const std::function<bool()>& condition) {
    return Eventually([&] {
      supervisor_.Step();
      return condition();
    });
  }

  // Another process than `first` works under the name.
  bool ComesBack(const std::string& name, pid_t first) {
    return StepUntil([&] { return PidIn(File(name)) != first && PidIn(File(name)) > 0; });
  }

  SupervisedProcess Described(const std::string& name) {
    const Supervision supervision = supervisor_.Describe();
    const SupervisedProcess* const process = supervision.Find(name);
    return process == nullptr ? SupervisedProcess{} : *process;
  }

  TemporaryFolder folder_;
  SystemClock clock_;
  std::vector<std::string> notices_;
  Supervisor supervisor_;
};

TEST_F(HangTest, AStoppedProcessIsSaidKilledRestartedAndCounted) {
  ASSERT_TRUE(Start("replay-0", "beat"));
  ASSERT_TRUE(Start("learner", "beat"));
  ASSERT_TRUE(StepUntil([&] { return PidIn(File("replay-0")) > 0 && PidIn(File("learner")) > 0; }));
  const pid_t first = PidIn(File("replay-0"));
  const pid_t other = PidIn(File("learner"));
  kill(first, SIGSTOP);
  // It shows before the supervisor acts.
  EXPECT_TRUE(StepUntil([&] { return Described("replay-0").fault == "hangs"; }));
  EXPECT_THAT(Described("replay-0").trouble, HasSubstr("stopped by a signal"));
  ASSERT_TRUE(ComesBack("replay-0", first));
  EXPECT_THAT(notices_,
              Contains(AllOf(HasSubstr("replay-0 hangs: it is stopped"), HasSubstr("replay-0.log"))));
  EXPECT_THAT(notices_, Contains(HasSubstr("starting it again")));
  EXPECT_EQ(Described("replay-0").hangs, 1);
  EXPECT_EQ(Described("replay-0").restarts, 1);
  EXPECT_EQ(Described("replay-0").last_end, "it hung: it is stopped by a signal");
  EXPECT_EQ(PidIn(File("learner")), other);
  EXPECT_TRUE(IsDead(first));
}

TEST_F(HangTest, ADeadlockLeavesItsStackInTheLog) {
  ASSERT_TRUE(Start("actor-0", "deadlock"));
  ASSERT_TRUE(StepUntil([&] { return PidIn(File("actor-0")) > 0; }));
  ASSERT_TRUE(ComesBack("actor-0", PidIn(File("actor-0"))));
  EXPECT_THAT(notices_, Contains(HasSubstr("its thread 'work' has been silent")));
  const std::string log = FileText(folder_.path() / "actor-0.log");
  EXPECT_THAT(log, AllOf(HasSubstr("hangs; its threads:"), HasSubstr("state S"), HasSubstr("stack of thread"),
                         HasSubstr("test_worker(")));
}

TEST_F(HangTest, AProcessThatGetsOnIsLeftAloneAndTellsWhatItCameTo) {
  ASSERT_TRUE(Start("learner", "beat"));
  ASSERT_TRUE(
      StepUntil([&] { return supervisor_.Work("learner") == 7 && Described("learner").state == "running"; }));
  // Its own word on what holds it up.
  EXPECT_TRUE(StepUntil([&] { return Described("learner").fault == "cannot store experience"; }));
  const pid_t first = PidIn(File("learner"));
  const TimePoint end = clock_.Now() + 2s;
  EXPECT_TRUE(StepUntil([&] { return clock_.Now() > end; }));
  EXPECT_EQ(PidIn(File("learner")), first);
  EXPECT_EQ(Described("learner").restarts, 0);
}

TEST_F(HangTest, AHungProcessIsKilledAtOnceWhenItsRoleIsToEnd) {
  ASSERT_TRUE(Start("actor-0", "beat"));
  ASSERT_TRUE(StepUntil([&] { return PidIn(File("actor-0")) > 0; }));
  kill(PidIn(File("actor-0")), SIGSTOP);
  ASSERT_TRUE(StepUntil([&] { return !notices_.empty(); }));
  supervisor_.StopRole("actor");
  EXPECT_TRUE(StepUntil([&] { return supervisor_.AllEnded(); }));
  EXPECT_EQ(Described("actor-0").state, "ended");
}

TEST(CapturedProcess, TellsThatItHangs) {
  const TemporaryFolder folder;
  const std::string pid_file = folder.path() / "pid";
  auto process =
      CapturedProcess::Spawn({DADRL_BINARY_DIR "/tests/test_worker", "beat", pid_file}, 0, {.silent = 500ms});
  ASSERT_TRUE(process);
  ASSERT_TRUE(Eventually([&] { return PidIn(pid_file) > 0; }));
  EXPECT_FALSE(process->Hangs());
  kill(process->child().pid(), SIGSTOP);
  EXPECT_TRUE(Eventually([&] { return process->Hangs().has_value(); }));
}

}  // namespace
}  // namespace dadrl
