// What must hold when processes of a running cluster are killed (README, "What fails, and what happens").
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

#include "common/model/policy_file.h"
#include "common/util/csv.h"
#include "tests/integration/cluster_under_test.h"
#include "tests/integration/stored_experience.h"

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

  void TearDown() override { Stop(); }

  // Drains the run, when it has not ended.
  void Stop() {
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
  Stop();
  ExpectEveryChunkOnce(cluster_.run());
}

// What a replay held when it began to serve, at each of its starts.
std::vector<double> FramesServed(const std::string& log) {
  const std::regex line("shard 0 serves ([0-9]+) frames");
  std::vector<double> frames;
  for (std::sregex_iterator found(log.begin(), log.end(), line), end; found != end; ++found) {
    frames.push_back(std::stod((*found)[1]));
  }
  return frames;
}

TEST_F(FailureTest, KilledReplayComesBackWithItsExperience) {
  // More than what a new replay could be mistaken for.
  before_ = cluster_.MonitorUntil([](const json& monitor) { return monitor["replay_frames"] > 1000.0; });
  ASSERT_TRUE(before_) << cluster_.Said();
  const double updates = (*before_)["updates"];
  const auto after = KillAndWait("replay-0", [&](const json& monitor) {
    return IsTraining(monitor) && monitor["updates"] > updates + 20 && monitor["inserted_frames_per_s"] > 0.0;
  });
  ASSERT_TRUE(after) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "learner")) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "actor-0")) << cluster_.Said();
  // It had all of it when it began, before any actor could send it something.
  const auto served = FramesServed(FileText(cluster_.run() / "logs/replay-0.log"));
  ASSERT_EQ(served.size(), 2u);
  EXPECT_EQ(served[0], 0.0);
  EXPECT_GE(served[1], (*before_)["replay_frames"].get<double>());
  Stop();
  ExpectEveryChunkOnce(cluster_.run());
}

// A column of logs/training.csv.
std::vector<double> TrainingColumn(const std::filesystem::path& run, const std::string& name) {
  std::ifstream table(run / "logs" / "training.csv");
  std::string row;
  std::getline(table, row);
  const auto columns = CsvCells(row);
  const auto column = static_cast<size_t>(std::find(columns.begin(), columns.end(), name) - columns.begin());
  std::vector<double> values;
  while (std::getline(table, row)) {
    const auto cells = CsvCells(row);
    if (cells.size() == columns.size()) values.push_back(std::stod(std::string(cells.at(column))));
  }
  return values;
}

TEST_F(FailureTest, KilledLearnerGoesOnFromItsCheckpoint) {
  uint64_t saved = 0;  // updates of a checkpoint that is surely there
  ASSERT_TRUE(Eventually([&] {
    const auto policy = LoadPolicy(cluster_.run() / "checkpoints/latest");
    saved = policy ? policy->updates : 0;
    return saved >= 50;
  })) << cluster_.Said();
  before_ = cluster_.Monitor();
  ASSERT_TRUE(before_);
  const double version = (*before_)["weights_version"];
  const size_t rows = TrainingColumn(cluster_.run(), "updates").size();
  const auto after = KillAndWait("learner", [&](const json& monitor) {
    return IsTraining(monitor) && MetricOf(monitor, "actor-0", "policy_version") > version;
  });
  ASSERT_TRUE(after) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "actor-0")) << cluster_.Said();
  EXPECT_TRUE(WasLeftAlone(*after, "replay-0")) << cluster_.Said();
  Stop();
  // Whatever the new one reported, from its first word on: it never counted from less than that checkpoint,
  // and versions never went back: the actors would not take them.
  const auto updates = TrainingColumn(cluster_.run(), "updates");
  const auto versions = TrainingColumn(cluster_.run(), "weights_version");
  ASSERT_GT(updates.size(), rows);
  EXPECT_GE(*std::min_element(updates.begin() + static_cast<std::ptrdiff_t>(rows), updates.end()),
            static_cast<double>(saved));
  EXPECT_TRUE(std::is_sorted(versions.begin(), versions.end()));
  const auto times = TrainingColumn(cluster_.run(), "wall_time_s");
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
  // Both learners' log has a start: TensorBoard drops what the second one does again.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(cluster_.run() / "tensorboard"), {}), 2);
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
