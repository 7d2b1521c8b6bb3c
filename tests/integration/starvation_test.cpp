// A busy machine is no fault: nobody who only waits for a core is taken to hang.
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <csignal>

#include "common/util/resources.h"
#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

// As many processes as four times the cores, each with all it can get.
class BusyMachine {
 public:
  BusyMachine() {
    for (int i = 0; i < 4 * UsableCores(); ++i) {
      auto spinning = ChildProcess::Spawn({.command = {"/bin/sh", "-c", "while :; do :; done"}, .log = {}});
      if (spinning) spinning_.push_back(std::move(*spinning));
    }
  }

 private:
  std::vector<ChildProcess> spinning_;
};

TEST(Starvation, IsNotTakenForAHang) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = SmallTraining();
  arguments.insert(arguments.begin(), "left_turn");
  // The shortest limit there is, and more actors than cores.
  arguments.insert(arguments.end(), {"--set", "cluster.liveliness_s=0.2", "--set", "actor.count=4"});
  ClusterUnderTest cluster(folder.path() / "run", arguments);
  const auto before = cluster.MonitorUntil([](const json& monitor) { return IsTraining(monitor); }, 120);
  ASSERT_TRUE(before) << cluster.Said();
  std::optional<json> after;
  {
    const BusyMachine busy;
    // At two to four updates a second: a minute or more of it, each second of which could be taken for a
    // hang.
    const double updates = (*before)["updates"];
    after = cluster.MonitorUntil(
        [&](const json& monitor) { return IsTraining(monitor) && monitor["updates"] > updates + 200; }, 150);
  }
  ASSERT_TRUE(after) << cluster.Said();
  EXPECT_THAT(cluster.Said(), testing::Not(testing::HasSubstr(" hangs: ")));
  for (const json& row : (*after)["processes"]) EXPECT_EQ(row["restarts"], 0) << row["name"];
  cluster.launcher().Signal(SIGINT);
  EXPECT_EQ(cluster.WaitForEnd(120), 0) << cluster.Said();
}

}  // namespace
}  // namespace dadrl
