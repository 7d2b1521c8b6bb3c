// What must hold when processes of a running cluster hang, and when all of it is stopped and continued.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>

#include "deploy/monitor/supervision.h"
#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

std::vector<std::string> LeftTurn(const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments = SmallTraining();
  arguments.insert(arguments.begin(), "left_turn");
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

// Gets on from where `before` was.
std::function<bool(const json&)> TrainsBeyond(const json& before) {
  const double updates = before["updates"];
  return [updates](const json& monitor) { return IsTraining(monitor) && monitor["updates"] > updates; };
}

std::string TroubleOf(const json& monitor, const std::string& name) {
  const json row = ProcessIn(monitor, name);
  return row.is_null() ? "" : row["trouble"].get<std::string>();
}

class HangingCluster : public testing::Test {
 protected:
  // With a hang limit of two seconds.
  void Begin(std::vector<std::string> more = {}) {
    more.insert(more.end(), {"--set", "cluster.liveliness_s=0.4"});
    cluster_.emplace(folder_.path() / "run", LeftTurn(more));
    before_ = cluster_->MonitorUntil([](const json& monitor) { return IsTraining(monitor); });
    ASSERT_TRUE(before_) << cluster_->Said();
  }

  void TearDown() override {
    if (!cluster_ || cluster_->launcher().TryWait()) return;
    cluster_->launcher().Signal(SIGINT);
    EXPECT_EQ(cluster_->WaitForEnd(90), 0) << cluster_->Said();
  }

  std::vector<pid_t> Pids() const {
    std::vector<pid_t> pids;
    for (const json& row : (*before_)["processes"]) pids.push_back(row["pid"]);
    return pids;
  }

  TemporaryFolder folder_;
  std::optional<ClusterUnderTest> cluster_;
  std::optional<json> before_;
};

TEST_F(HangingCluster, WhoeverIsStoppedIsFoundKilledAndRestartedAndTheRunGoesOn) {
  Begin();
  for (const char* name : {"actor-0", "replay-0", "learner"}) {
    const pid_t victim = PidOf(*before_, name);
    ASSERT_GT(victim, 0) << name;
    kill(victim, SIGSTOP);
    // A monitor that is started now sees who hangs.
    EXPECT_TRUE(cluster_->MonitorUntil([&](const json& monitor) {
      return !TroubleOf(monitor, name).empty() && !monitor["troubles"].empty();
    })) << name
        << cluster_->Said();
    const auto after = cluster_->MonitorUntil([&](const json& monitor) {
      const json row = ProcessIn(monitor, name);
      return row["hangs"] == 1 && row["pid"] != victim && row["trouble"] == "" && IsTraining(monitor);
    });
    ASSERT_TRUE(after) << name << cluster_->Said();
    EXPECT_TRUE(IsDead(victim));
    EXPECT_THAT(cluster_->Said(), HasSubstr(std::string(name) + " hangs: it is stopped by a signal"));
    before_ = cluster_->MonitorUntil(TrainsBeyond(*after));
    ASSERT_TRUE(before_) << name << cluster_->Said();
  }
}

TEST_F(HangingCluster, CtrlZStopsItAllAndGoingOnLosesNobody) {
  Begin();
  const std::vector<pid_t> pids = Pids();
  const pid_t launcher = cluster_->launcher().pid();
  kill(-launcher, SIGTSTP);
  ASSERT_TRUE(Eventually([&] { return IsStopped(launcher); })) << cluster_->Said();
  for (const pid_t pid : pids) EXPECT_TRUE(Eventually([&] { return IsStopped(pid); })) << pid;
  const auto stopped = cluster_->Monitor();
  ASSERT_TRUE(stopped);
  EXPECT_THAT((*stopped)["troubles"].dump(), HasSubstr("launcher: stopped by a signal"));
  // Longer than the limit after which one of them alone would be taken to hang.
  SystemClock().SleepFor(std::chrono::seconds(4));
  kill(-launcher, SIGCONT);
  const auto after = cluster_->MonitorUntil(TrainsBeyond(*before_));
  ASSERT_TRUE(after) << cluster_->Said();
  for (const char* name : {"actor-0", "replay-0", "learner"}) {
    EXPECT_EQ(PidOf(*after, name), PidOf(*before_, name)) << name << cluster_->Said();
    EXPECT_EQ(ProcessIn(*after, name)["restarts"], 0) << name;
  }
}

TEST_F(HangingCluster, NohupOutlivesItsTerminal) {
  signal(SIGHUP, SIG_IGN);  // as nohup does
  Begin();
  signal(SIGHUP, SIG_DFL);
  std::vector<pid_t> pids = Pids();
  pids.push_back(cluster_->launcher().pid());
  for (const pid_t pid : pids) kill(pid, SIGHUP);
  const auto after = cluster_->MonitorUntil(TrainsBeyond(*before_));
  ASSERT_TRUE(after) << cluster_->Said();
  for (const pid_t pid : pids) EXPECT_FALSE(IsDead(pid));
}

TEST_F(HangingCluster, AStoppedLauncherLeavesItsProcessesWorkingAndShows) {
  Begin();
  const pid_t launcher = cluster_->launcher().pid();
  kill(launcher, SIGSTOP);
  const auto after = cluster_->MonitorUntil(TrainsBeyond(*before_));
  kill(launcher, SIGCONT);
  ASSERT_TRUE(after) << cluster_->Said();
  EXPECT_THAT((*after)["troubles"].dump(), HasSubstr("nothing is supervised until kill -CONT"));
}

}  // namespace
}  // namespace dadrl
