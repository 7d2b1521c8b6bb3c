// What must hold when processes of a running cluster are killed (README, "What fails, and what happens").
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <csignal>

#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

std::vector<std::string> LeftTurn() {
  std::vector<std::string> arguments = SmallTraining();
  arguments.insert(arguments.begin(), "left_turn");
  return arguments;
}

class FailureTest : public testing::Test {
 protected:
  FailureTest() : cluster_(folder_.path() / "run", LeftTurn()) {}

  void SetUp() override {
    before_ = cluster_.MonitorUntil([](const json& monitor) { return IsTraining(monitor); });
    ASSERT_TRUE(before_) << cluster_.Said();
  }

  void TearDown() override {
    if (cluster_.launcher().TryWait()) return;
    cluster_.launcher().Signal(SIGINT);
    EXPECT_EQ(cluster_.WaitForEnd(60), 0) << cluster_.Said();
  }

  // Kills `name` and waits until another process of that name is there and `condition` holds.
  std::optional<json> KillAndWait(const std::string& name,
                                  const std::function<bool(const json&)>& condition) {
    const pid_t victim = PidOf(*before_, name);
    EXPECT_GT(victim, 0) << name;
    if (victim <= 0 || kill(victim, SIGKILL) != 0) return std::nullopt;
    return cluster_.MonitorUntil([&](const json& monitor) {
      const json row = ProcessIn(monitor, name);
      return !row.is_null() && row["pid"] != victim && row["stale"] == false && condition(monitor);
    });
  }

  // The same process as before.
  bool WasLeftAlone(const json& after, const std::string& name) const {
    return PidOf(after, name) == PidOf(*before_, name);
  }

  TemporaryFolder folder_;
  ClusterUnderTest cluster_;
  std::optional<json> before_;
};

TEST_F(FailureTest, KilledActorComesBackAndTrainingGoesOn) {
  const double updates = (*before_)["updates"];
  const auto after = KillAndWait("actor-0", [&](const json& monitor) {
    return IsTraining(monitor) && monitor["updates"] > updates + 20 &&
           MetricOf(monitor, "actor-0", "policy_version") > 0;
  });
  ASSERT_TRUE(after) << cluster_.Said();
  // Nobody else noticed.
  EXPECT_TRUE(WasLeftAlone(*after, "learner")) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "replay-0")) << cluster_.Said();
}

TEST_F(FailureTest, KilledReplayComesBackWithItsExperience) {
  const double updates = (*before_)["updates"];
  const double frames = (*before_)["replay_frames"];
  const auto after = KillAndWait("replay-0", [&](const json& monitor) {
    return IsTraining(monitor) && monitor["updates"] > updates + 20 && monitor["inserted_frames_per_s"] > 0.0;
  });
  ASSERT_TRUE(after) << cluster_.Said();
  EXPECT_GE((*after)["replay_frames"], frames);
  EXPECT_TRUE(WasLeftAlone(*after, "learner")) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "actor-0")) << cluster_.Said();
}

TEST_F(FailureTest, KilledLearnerGoesOnFromItsCheckpoint) {
  // A checkpoint first, so that there is something to go on from.
  ASSERT_TRUE(Eventually([&] { return std::filesystem::exists(cluster_.run() / "checkpoints/latest"); }))
      << cluster_.Said();
  before_ = cluster_.Monitor();
  ASSERT_TRUE(before_);
  const double updates = (*before_)["updates"];
  const double version = (*before_)["weights_version"];
  const auto after = KillAndWait("learner", [&](const json& monitor) {
    // Versions never go back: the actors would not take them.
    return IsTraining(monitor) && monitor["updates"] > updates && monitor["weights_version"] > version &&
           MetricOf(monitor, "actor-0", "policy_version") > version;
  });
  ASSERT_TRUE(after) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "actor-0")) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "replay-0")) << cluster_.Said();
}

TEST_F(FailureTest, KilledLauncherLeavesNoOrphansAndTheRunCanBeResumed) {
  std::vector<pid_t> pids;
  for (const json& row : (*before_)["processes"]) pids.push_back(row["pid"]);
  ASSERT_GE(pids.size(), 3u);
  for (const pid_t pid : pids) ASSERT_FALSE(IsDead(pid));
  kill(cluster_.launcher().pid(), SIGKILL);
  for (const pid_t pid : pids) EXPECT_TRUE(Eventually([&] { return IsDead(pid); })) << pid;

  ClusterUnderTest resumed(cluster_.run(), {"--resume"});
  const double updates = (*before_)["updates"];
  EXPECT_TRUE(resumed.MonitorUntil([&](const json& monitor) {
    return IsTraining(monitor) && monitor["updates"] > updates;
  })) << resumed.Said();
  resumed.launcher().Signal(SIGINT);
  EXPECT_EQ(resumed.WaitForEnd(60), 0) << resumed.Said();
}

TEST_F(FailureTest, SecondInterruptKillsAtOnce) {
  std::vector<pid_t> pids;
  for (const json& row : (*before_)["processes"]) pids.push_back(row["pid"]);
  // Stopped, the learner cannot drain.
  const pid_t learner = PidOf(*before_, "learner");
  kill(learner, SIGSTOP);
  cluster_.launcher().Signal(SIGINT);
  ASSERT_TRUE(
      Eventually([&] { return cluster_.Said().find("waiting for the learner") != std::string::npos; }));
  cluster_.launcher().Signal(SIGINT);
  EXPECT_EQ(cluster_.WaitForEnd(20), 1) << cluster_.Said();
  for (const pid_t pid : pids) EXPECT_TRUE(Eventually([&] { return IsDead(pid); })) << pid;
}

}  // namespace
}  // namespace dadrl
