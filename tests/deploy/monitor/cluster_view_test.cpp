#include "deploy/monitor/cluster_view.h"

#include <gmock/gmock.h>

#include "tests/deploy/monitor/statuses.h"

namespace dadrl {
namespace {

using std::chrono::seconds;
constexpr TimePoint kStart{};

ClusterView MakeView() { return {seconds(10), seconds(3)}; }

ProcessStatus Actor(int index, double uptime_s, double env_steps, uint64_t incarnation = 1) {
  ProcessStatus status = MakeStatus(dds::Role::kActor, index, uptime_s, incarnation);
  status[Metric::kEnvSteps] = env_steps;
  status[Metric::kEpisodes] = env_steps / 100;
  return status;
}

TEST(ClusterView, IsEmptyBeforeAnyMessage) {
  const ClusterSummary summary = MakeView().Summarize(kStart);
  EXPECT_TRUE(summary.processes.empty());
  EXPECT_EQ(summary.env_steps_per_s, 0.0);
  EXPECT_EQ(summary.recent_episodes, 0);
}

TEST(ClusterView, GathersFaultsThoseThatHoldUpTrainingFirst) {
  ClusterView view = MakeView();
  ProcessStatus learner = MakeStatus(dds::Role::kLearner, 0, 5.0);
  learner.faults = {{FaultKind::kTrainingLog, "y", 2.0}};
  ProcessStatus replay = MakeStatus(dds::Role::kReplay, 1, 5.0);
  replay.faults = {{FaultKind::kState, "s", 1.0}, {FaultKind::kExperience, "x", 3.0}};
  view.Add(learner, kStart);
  view.Add(replay, kStart);
  std::vector<ProcessFault> faults = view.Summarize(kStart).faults;
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_EQ(faults.front(), (ProcessFault{"replay-1", replay.faults[1]}));
  replay.faults.clear();
  replay.uptime_s += 1.0;
  view.Add(replay, kStart + seconds(1));
  EXPECT_EQ(view.Summarize(kStart + seconds(1)).faults.size(), 1u);
  EXPECT_TRUE(view.Summarize(kStart + seconds(9)).faults.empty()) << "who is silent is not believed";
}

TEST(ClusterView, SumsRatesOverProcesses) {
  ClusterView view = MakeView();
  view.Add(Actor(0, 5.0, 1000), kStart);
  view.Add(Actor(1, 7.0, 500), kStart);
  view.Add(Actor(0, 7.0, 1400), kStart + seconds(2));  // 200/s
  view.Add(Actor(1, 9.0, 600), kStart + seconds(2));   // 50/s
  const ClusterSummary summary = view.Summarize(kStart + seconds(2));
  EXPECT_DOUBLE_EQ(summary.env_steps_per_s, 250.0);
  EXPECT_DOUBLE_EQ(summary.env_steps, 2000.0);
  EXPECT_EQ(summary.actors_alive, 2);
  EXPECT_EQ(view.ReportingProcesses(kStart + seconds(2)), 2);
}

TEST(ClusterView, OneMessageGivesNoRate) {
  ClusterView view = MakeView();
  view.Add(Actor(0, 100.0, 12345), kStart);  // a resumed counter must not look like a burst
  EXPECT_EQ(view.Summarize(kStart).env_steps_per_s, 0.0);
  EXPECT_EQ(view.ReportingProcesses(kStart), 0);
}

TEST(ClusterView, HoldsABoundedNumberOfProcesses) {
  ClusterView view = MakeView();
  int taken = 0;
  for (int index = 0; index < 100'000; ++index) taken += view.Add(Actor(index, 1.0, 1), kStart) ? 1 : 0;
  EXPECT_EQ(view.Summarize(kStart).processes.size(), static_cast<size_t>(taken));
  EXPECT_LT(taken, 10'000);
  EXPECT_TRUE(view.Add(Actor(5, 2.0, 1), kStart)) << "who is known is heard";
  EXPECT_FALSE(view.Add(Actor(100'000, 1.0, 1), kStart + seconds(1)));
  EXPECT_TRUE(view.Add(Actor(100'000, 1.0, 1), kStart + seconds(5))) << "the forged ones have gone stale";
}

TEST(ClusterView, HoldsABoundedNumberOfMessages) {
  ClusterView view = MakeView();
  double uptime_s = 1.0;
  for (int i = 0; i < 100'000; ++i) view.Add(Actor(0, uptime_s += 1e-6, i), kStart);
  const double rate = view.Summarize(kStart).env_steps_per_s;
  EXPECT_LT(rate, 1e6) << "what no clock measures is no time";
  EXPECT_GT(rate, 0.0);
}

TEST(ClusterView, ForgetsWhatIsOlderThanTheWindow) {
  ClusterView view = MakeView();
  double steps = 0.0;
  for (int t = 0; t <= 60; ++t) {
    steps += t <= 40 ? 1000.0 : 10.0;
    view.Add(Actor(0, t, steps), kStart + seconds(t));
  }
  EXPECT_DOUBLE_EQ(view.Summarize(kStart + seconds(60)).env_steps_per_s, 10.0);
}

TEST(ClusterView, FlagsSilentProcessesAndCountsThemAsIdle) {
  ClusterView view = MakeView();
  view.Add(Actor(0, 1.0, 0), kStart);
  view.Add(Actor(0, 2.0, 100), kStart + seconds(1));
  const ClusterSummary summary = view.Summarize(kStart + seconds(5));
  ASSERT_EQ(summary.processes.size(), 1u);
  EXPECT_TRUE(summary.processes[0].stale);
  EXPECT_DOUBLE_EQ(summary.processes[0].silent_s, 4.0);
  EXPECT_EQ(summary.env_steps_per_s, 0.0);
  EXPECT_EQ(summary.actors_alive, 0);
  EXPECT_EQ(summary.env_steps, 100.0);
}

TEST(ClusterView, KeepsTotalsOverARestartAndNeverShowsNegativeRates) {
  ClusterView view = MakeView();
  view.Add(Actor(0, 10.0, 900, 1), kStart);
  view.Add(Actor(0, 11.0, 1000, 1), kStart + seconds(1));
  view.Add(Actor(0, 0.5, 20, 2), kStart + seconds(2));
  EXPECT_EQ(view.Summarize(kStart + seconds(2)).env_steps_per_s, 0.0);
  view.Add(Actor(0, 1.5, 70, 2), kStart + seconds(3));
  const ClusterSummary summary = view.Summarize(kStart + seconds(3));
  EXPECT_DOUBLE_EQ(summary.env_steps_per_s, 50.0);
  EXPECT_DOUBLE_EQ(summary.env_steps, 1070.0);
  EXPECT_EQ(summary.processes[0].restarts, 1);
}

TEST(ClusterView, IgnoresTheLateWordOfADeadIncarnation) {
  ClusterView view = MakeView();
  view.Add(Actor(0, 1.0, 10, 2), kStart);
  view.Add(Actor(0, 99.0, 9999, 1), kStart);
  EXPECT_EQ(view.Summarize(kStart).env_steps, 10.0);
  EXPECT_EQ(view.Summarize(kStart).processes[0].restarts, 0);
}

TEST(ClusterView, SharesOfTimeBecomeWaitsLongestFirst) {
  ClusterView view = MakeView();
  ProcessStatus learner = MakeStatus(dds::Role::kLearner, 0, 10.0);
  learner.activities[Activity::kWork].seconds = 100.0;  // before the window's first message: must not count
  view.Add(learner, kStart);
  learner.uptime_s = 20.0;
  learner.activities[Activity::kWork].seconds += 5.0;
  learner.activities[Activity::kWaitForInserts] = {7, 3.0};
  learner.activities[Activity::kWaitForBatch] = {400, 2.0};
  view.Add(learner, kStart + seconds(10));
  const ClusterSummary summary = view.Summarize(kStart + seconds(10));
  ASSERT_EQ(summary.waits.size(), 2u);
  EXPECT_EQ(summary.waits[0].who, "learner");
  EXPECT_EQ(summary.waits[0].for_what, "inserts");
  EXPECT_DOUBLE_EQ(summary.waits[0].fraction, 0.3);
  EXPECT_EQ(summary.waits[1].for_what, "batch");
  EXPECT_EQ(summary.waits[1].spent, (TimeSpent{400, 2.0}));
  EXPECT_DOUBLE_EQ(summary.processes[0].Share(Activity::kWork), 0.5);
}

TEST(ClusterView, AWaitThatIsOverStaysCounted) {
  ClusterView view = MakeView();
  ProcessStatus replay = MakeStatus(dds::Role::kReplay, 0, 10.0);
  replay.activities[Activity::kWaitForDisk] = {3, 0.5};
  view.Add(replay, kStart);
  replay.uptime_s = 20.0;
  replay.activities[Activity::kWork] = {1, 10.0};
  view.Add(replay, kStart + seconds(10));
  const ClusterSummary summary = view.Summarize(kStart + seconds(10));
  ASSERT_EQ(summary.waits.size(), 1u);
  EXPECT_EQ(summary.waits[0].for_what, "disk");
  EXPECT_EQ(summary.waits[0].fraction, 0.0);
  EXPECT_EQ(summary.waits[0].spent, (TimeSpent{3, 0.5}));
}

TEST(ClusterView, AddsReplayShardsAndTakesTheLearnersWord) {
  ClusterView view = MakeView();
  for (int t = 0; t < 2; ++t) {
    for (int shard = 0; shard < 2; ++shard) {
      ProcessStatus replay = MakeStatus(dds::Role::kReplay, shard, 1.0 + t);
      replay[Metric::kInsertedFrames] = 100.0 * t;
      replay[Metric::kInsertedBytes] = 1e6 * t;
      replay[Metric::kSampledTransitions] = 800.0 * t;
      replay[Metric::kSampledBytes] = 3e6 * t;
      replay[Metric::kFramesHeld] = 5000;
      replay[Metric::kMemoryBytes] = 1e7;
      replay[Metric::kSnapshotBytes] = 2e6;
      view.Add(replay, kStart + seconds(t));
    }
    ProcessStatus learner = MakeStatus(dds::Role::kLearner, 0, 1.0 + t);
    learner[Metric::kUpdates] = 70 + 25.0 * t;
    learner[Metric::kWeightsVersion] = 8;
    learner[Metric::kStalenessVersionsMean] = 2.5;
    learner[Metric::kStalenessSecondsMax] = 9.0;
    view.Add(learner, kStart + seconds(t));
  }
  const ClusterSummary summary = view.Summarize(kStart + seconds(1));
  EXPECT_DOUBLE_EQ(summary.inserted_frames_per_s, 200.0);
  EXPECT_DOUBLE_EQ(summary.sampled_transitions_per_s, 1600.0);
  EXPECT_DOUBLE_EQ(summary.inserted_mb_per_s, 2.0);
  EXPECT_DOUBLE_EQ(summary.sampled_mb_per_s, 6.0);
  EXPECT_DOUBLE_EQ(summary.replay_frames, 10000.0);
  EXPECT_DOUBLE_EQ(summary.snapshot_bytes, 4e6);
  EXPECT_DOUBLE_EQ(summary.updates_per_s, 25.0);
  EXPECT_DOUBLE_EQ(summary.updates, 95.0);
  EXPECT_EQ(summary.weights_version, 8.0);
  EXPECT_EQ(summary.staleness_versions.mean, 2.5);
  EXPECT_EQ(summary.staleness_s.max, 9.0);
  ASSERT_EQ(summary.processes.size(), 3u);
  EXPECT_EQ(summary.processes[0].name, "learner");
  EXPECT_EQ(summary.processes[2].name, "replay-1");
}

TEST(ClusterView, AddsUpWhatWasRejectedByKindOverShardsAndRestarts) {
  ClusterView view = MakeView();
  for (int shard = 0; shard < 2; ++shard) {
    ProcessStatus replay = MakeStatus(dds::Role::kReplay, shard, 5.0, 1);
    replay[Metric::kDuplicateChunks] = 10;
    replay[Metric::kRejectedChecksum] = 1;
    replay[Metric::kRefusedPriorities] = 2;
    view.Add(replay, kStart);
  }
  ProcessStatus restarted = MakeStatus(dds::Role::kReplay, 1, 1.0, 2);
  restarted[Metric::kDuplicateChunks] = 3;
  view.Add(restarted, kStart + seconds(1));
  ProcessStatus learner = MakeStatus(dds::Role::kLearner, 0, 5.0);
  learner[Metric::kCorruptBatches] = 4;
  view.Add(learner, kStart);
  EXPECT_THAT(view.Summarize(kStart + seconds(1)).rejected,
              testing::UnorderedElementsAre(
                  testing::Pair("duplicate", 23.0), testing::Pair("wrong checksum", 2.0),
                  testing::Pair("impossible priority", 4.0), testing::Pair("corrupt batch", 4.0)));
}

TEST(ClusterView, RatesOfTheLastHundredEpisodes) {
  ClusterView view = MakeView();
  EpisodeReport report;
  report.outcome = 1;
  for (int i = 0; i < 500; ++i) view.Add(report);
  report.outcome = 0;
  report.episode_return = 4.0;
  for (int i = 0; i < 75; ++i) view.Add(report);
  report.outcome = 17;  // not an outcome: dropped
  view.Add(report);
  const ClusterSummary summary = view.Summarize(kStart);
  EXPECT_EQ(summary.recent_episodes, 100);
  EXPECT_NEAR(summary.recent_success, 0.75, 1e-9);
  EXPECT_NEAR(summary.recent_collision, 0.25, 1e-9);
  EXPECT_NEAR(summary.recent_return, 3.0, 1e-9);
}

TEST(ClusterView, RecentSuccessByScenario) {
  ClusterView view = MakeView();
  for (int i = 0; i < 5; ++i) {
    EpisodeReport report;
    report.scenario = i < 4 ? "left_turn" : "double_merge";
    report.outcome = i == 0 ? 0 : 1;
    view.Add(report);
  }
  const ClusterSummary summary = view.Summarize(kStart);
  ASSERT_EQ(summary.recent_scenarios.size(), 2u);
  EXPECT_EQ(summary.recent_scenarios.at("left_turn").episodes, 4);
  EXPECT_DOUBLE_EQ(summary.recent_scenarios.at("left_turn").success, 0.25);
  EXPECT_DOUBLE_EQ(summary.recent_scenarios.at("double_merge").success, 0.0);
}

}  // namespace
}  // namespace dadrl
