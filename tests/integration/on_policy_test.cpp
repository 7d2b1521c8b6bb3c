// On policy over DDS: fresh steps only, trained on once, whoever is killed.
#include <gmock/gmock.h>

#include <csignal>

#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

constexpr double kMaxStaleness = 4.0;
// One batch may be under way while the learner publishes once more (learner.credits 1).
constexpr double kUnderWay = 1.0;

std::vector<std::string> SmallPpo() {
  return {"left_turn",
          "--actors",
          "2",
          "--set",
          "algorithm.name=ppo",
          "--set",
          "algorithm.rollout=128",
          "--set",
          "algorithm.epochs=2",
          "--set",
          "replay.sequence_length=16",
          "--set",
          "replay.sequence_period=16",
          "--set",
          "replay.samples_per_insert_band=128",
          "--set",
          "model.hidden=32",
          "--set",
          "learner.checkpoint_interval_s=2",
          "--set",
          "telemetry.interval_s=0.2",
          "--set",
          "evaluation.interval_s=0",
          "--set",
          "evaluation.episodes=2",
          "--set",
          "evaluation.candidates=1"};
}

double Staleness(const json& monitor) { return MetricOf(monitor, "learner", "staleness_versions_max"); }

class OnPolicyTest : public testing::Test {
 protected:
  OnPolicyTest() : cluster_(folder_.path() / "run", SmallPpo()) {}

  void SetUp() override {
    before_ = cluster_.MonitorUntil(
        [](const json& monitor) { return IsTraining(monitor) && monitor["updates"] >= 3; });
    ASSERT_TRUE(before_) << cluster_.Said();
    EXPECT_LE(Staleness(*before_), kMaxStaleness + kUnderWay);
  }
  void TearDown() override {
    if (cluster_.launcher().TryWait()) return;
    cluster_.launcher().Signal(SIGINT);
    EXPECT_EQ(cluster_.WaitForEnd(60), 0) << cluster_.Said();
  }

  // Kills `name`; another of that name must be there, and the learner ten updates further, its steps fresh.
  void ExpectGoesOnWithout(const std::string& name) {
    const pid_t victim = PidOf(*before_, name);
    ASSERT_GT(victim, 0);
    ASSERT_EQ(kill(victim, SIGKILL), 0);
    std::optional<double> from;  // updates when the new one was seen
    double stalest = 0.0;
    const auto after = cluster_.MonitorUntil([&](const json& monitor) {
      const json row = ProcessIn(monitor, name);
      if (row.is_null() || row["pid"] == victim || row["stale"] != false) return false;
      if (!from) from = monitor["updates"].get<double>();
      if (monitor["updates"].get<double>() < *from) from = monitor["updates"].get<double>();
      stalest = std::max(stalest, Staleness(monitor));
      return monitor["updates"].get<double>() >= *from + 10.0;
    });
    ASSERT_TRUE(after) << cluster_.Said();
    EXPECT_LE(stalest, kMaxStaleness + kUnderWay);
  }

  TemporaryFolder folder_;
  ClusterUnderTest cluster_;
  std::optional<json> before_;
};

TEST_F(OnPolicyTest, KilledActorLeavesTheLearnerToFreshSteps) { ExpectGoesOnWithout("actor-1"); }
TEST_F(OnPolicyTest, KilledReplayLeavesTheLearnerToFreshSteps) { ExpectGoesOnWithout("replay-0"); }
TEST_F(OnPolicyTest, KilledLearnerGoesOnWithFreshSteps) { ExpectGoesOnWithout("learner"); }

}  // namespace
}  // namespace dadrl
