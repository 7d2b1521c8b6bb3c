#include "deploy/monitor/bottleneck.h"

#include <gmock/gmock.h>

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::StartsWith;

ProcessRow Row(dds::Role role, Activity activity, double share) {
  ProcessRow row;
  row.role = role;
  row.name = RoleName(role);
  row.share[activity] = share;
  row.share[Activity::kWork] = 1.0 - share;
  return row;
}

// A cluster at work: full replay, every process busy but for what the rows say.
ClusterSummary Busy(std::vector<ProcessRow> rows) {
  ClusterSummary summary;
  summary.processes = std::move(rows);
  summary.actors_alive = 1;
  summary.replay_frames = 1e6;
  summary.updates_per_s = 30;
  return summary;
}

struct Case {
  const char* name;
  ProcessRow learner;
  ProcessRow replay;
  ProcessRow actor;
  const char* expected;
};

class Bottleneck : public testing::TestWithParam<Case> {};

TEST(BottleneckOfAFault, NamesTheFaultAndNotWhatFollowsFromIt) {
  ClusterSummary summary = Busy({Row(dds::Role::kLearner, Activity::kWaitForInserts, 0.9),
                                 Row(dds::Role::kReplay, Activity::kWaitForInserts, 0.9),
                                 Row(dds::Role::kActor, Activity::kWaitForReplay, 0.9)});
  summary.faults = {{"replay-0", {FaultKind::kExperience, "cannot write x: Too many open files", 5.0}}};
  EXPECT_EQ(DescribeBottleneck(summary, Config{}), "replay-0: cannot write x: Too many open files");
  summary.faults = {{"learner", {FaultKind::kTrainingLog, "cannot write y", 5.0}}};
  EXPECT_THAT(DescribeBottleneck(summary, Config{}), StartsWith("actors: the learner waits"));
}

TEST_P(Bottleneck, NamesWhoHoldsTheOthersUp) {
  const Case& c = GetParam();
  EXPECT_THAT(DescribeBottleneck(Busy({c.learner, c.replay, c.actor}), Config{}), StartsWith(c.expected));
}

constexpr auto kL = dds::Role::kLearner;
constexpr auto kR = dds::Role::kReplay;
constexpr auto kA = dds::Role::kActor;

INSTANTIATE_TEST_SUITE_P(
    All, Bottleneck,
    testing::Values(
        Case{"LearnerStarves", Row(kL, Activity::kWaitForInserts, 0.45),
             Row(kR, Activity::kWaitForInserts, 0.9), Row(kA, Activity::kWork, 0),
             "actors: the learner waits 45 %"},
        Case{"LimiterHoldsBatches", Row(kL, Activity::kWaitForBatch, 0.4),
             Row(kR, Activity::kWaitForInserts, 0.5), Row(kA, Activity::kWork, 0),
             "actors: the learner waits 40 %"},
        Case{"SlowReplay", Row(kL, Activity::kWaitForBatch, 0.4), Row(kR, Activity::kWaitForCredits, 0.02),
             Row(kA, Activity::kWork, 0), "replay: the learner waits 40 %"},
        Case{"SlowLearner", Row(kL, Activity::kWork, 0), Row(kR, Activity::kWaitForSamples, 0.9),
             Row(kA, Activity::kWaitForReplay, 0.6),
             "learner: it computes 100 % of its time, and the actors are held back 60 % of theirs to keep "
             "replay.min_samples_per_insert"},
        Case{"SlowDisk", Row(kL, Activity::kWaitForBatch, 0.4), Row(kR, Activity::kWaitForDisk, 0.5),
             Row(kA, Activity::kWork, 0), "disk: the replay"},
        Case{"BusyLearner", Row(kL, Activity::kWaitForBatch, 0.02), Row(kR, Activity::kWaitForCredits, 0.9),
             Row(kA, Activity::kWork, 0), "learner: it computes 98 %"},
        Case{"Balanced", Row(kL, Activity::kWaitForBatch, 0.12), Row(kR, Activity::kWaitForCredits, 0.6),
             Row(kA, Activity::kWaitForReplay, 0.05), "none stands out"}),
    [](const auto& test) { return test.param.name; });

TEST(DescribeBottleneck, SaysWhoIsMissing) {
  const Config config;
  EXPECT_EQ(DescribeBottleneck({}, config), "starting: no replay has reported yet");
  ClusterSummary summary =
      Busy({Row(kL, Activity::kWork, 0), Row(kR, Activity::kWork, 0), Row(kA, Activity::kWork, 0)});
  summary.processes[0].stale = true;
  EXPECT_EQ(DescribeBottleneck(summary, config), "no learner reports; the others wait for it");
}

TEST(DescribeBottleneck, CountsFramesBeforeTraining) {
  ClusterSummary summary =
      Busy({Row(kL, Activity::kWaitForInserts, 1), Row(kR, Activity::kWork, 0), Row(kA, Activity::kWork, 0)});
  summary.replay_frames = 1240;
  summary.updates_per_s = 0;
  EXPECT_EQ(DescribeBottleneck(summary, Config{}),
            "actors: training starts at 2,000 frames, the replay holds 1,240");
}

TEST(Thousands, GroupsDigits) {
  EXPECT_EQ(Thousands(0), "0");
  EXPECT_EQ(Thousands(999), "999");
  EXPECT_EQ(Thousands(1000), "1,000");
  EXPECT_EQ(Thousands(1234567), "1,234,567");
  EXPECT_EQ(Thousands(-123456), "-123,456");
  EXPECT_EQ(Thousands(-123), "-123");
}

}  // namespace
}  // namespace dadrl
