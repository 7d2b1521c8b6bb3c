// A run that lost much of its time does not end as if nothing had been.
#include <gmock/gmock.h>

#include <csignal>
#include <fstream>

#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

TEST(HeldUpRun, EndsByItsClockWithExitCodeOneAndSaysWhatItLost) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = SmallTraining();
  arguments.insert(arguments.begin(), "left_turn");
  // A minute and a half, in which nothing is taken to hang.
  arguments.insert(arguments.end(),
                   {"--minutes", "1.5", "--set", "cluster.liveliness_s=60", "--set", "cluster.lease_s=60"});
  ClusterUnderTest cluster(folder.path() / "run", arguments);
  const auto before = cluster.MonitorUntil([](const json& monitor) { return IsTraining(monitor); }, 40);
  ASSERT_TRUE(before) << cluster.Said();
  kill(PidOf(*before, "replay-0"), SIGSTOP);
  EXPECT_EQ(cluster.WaitForEnd(250), 1) << cluster.Said();
  EXPECT_THAT(cluster.Said(), HasSubstr("s lost to faults"));
  EXPECT_THAT(cluster.Said(), HasSubstr("the training has not done its work"));
  const json results = json::parse(std::ifstream(cluster.run() / "results.json"));
  EXPECT_EQ(results["state"], "held_up");
  double lost_s = 0.0;
  for (const auto& [fault, seconds] : results["lost_s"].items()) lost_s += seconds.get<double>();
  EXPECT_GT(lost_s, 45.0);
}

}  // namespace
}  // namespace dadrl
