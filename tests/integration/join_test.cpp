// Actors that join a run from elsewhere: who is who, and what they do when the run ends.
#include <gmock/gmock.h>

#include <csignal>

#include "common/dds/node.h"
#include "deploy/monitor/supervision.h"
#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

class Join : public testing::Test {
 protected:
  // `dadrl actor --join` the run, with the actor number 7.
  std::vector<std::string> Command(const std::string& name, const std::string& first_index = "7") const {
    return {DadrlProgram(),  "actor",
            "--join",        "127.0.0.1:" + std::to_string(port_),
            "--first-index", first_index,
            "--run-dir",     (folder_.path() / name).string(),
            "--key",         (folder_.path() / "run" / "key").string()};
  }
  std::filesystem::path LogOf(const std::string& name) const { return folder_.path() / (name + ".log"); }

  const int port_ = dds::FindFreePort().value();
  TemporaryFolder folder_;
};

TEST_F(Join, OneActorHasANumberTheOtherIsToldAndBothEndWithTheRun) {
  std::vector<std::string> training = SmallTraining();
  training.insert(training.begin(), "left_turn");
  training.insert(training.end(), {"--set", fmt::format("cluster.port={}", port_)});
  ClusterUnderTest cluster(folder_.path() / "run", std::move(training));
  ASSERT_TRUE(cluster.MonitorUntil([](const json& monitor) { return IsTraining(monitor); }))
      << cluster.Said();
  auto first = ChildProcess::Spawn({.command = Command("first"), .log = LogOf("first")});
  ASSERT_TRUE(first);
  const auto drives = [](const json& monitor) { return MetricOf(monitor, "actor-7", "decisions"); };
  const auto before = cluster.MonitorUntil([&](const json& monitor) { return drives(monitor) > 0.0; });
  ASSERT_TRUE(before) << cluster.Said() << FileText(LogOf("first"));

  // What a monitor goes by that is started later, or when telemetry fails.
  EXPECT_TRUE(Eventually([&] {
    const auto known = LoadSupervision(folder_.path() / "first" / "processes.json");
    return known && known->Find("actor-7") != nullptr && known->Find("actor-7")->pid > 0;
  }));

  const CommandOutput second = RunCommand(Command("second"));
  EXPECT_EQ(second.exit_code, 1) << FileText(folder_.path() / "second" / "logs" / "actor-7.log");
  EXPECT_THAT(second.err, HasSubstr("actor number 7 is held by "));
  EXPECT_THAT(second.err, HasSubstr("not started again: another process has its place in the run"));
  const CommandOutput reserved = RunCommand(Command("third", "0"));
  EXPECT_EQ(reserved.exit_code, 2);
  EXPECT_THAT(reserved.err, HasSubstr("--first-index: 0 is one of the run's own actors, 0 to 0"));
  EXPECT_TRUE(cluster.MonitorUntil([&](const json& monitor) { return drives(monitor) > drives(*before); }))
      << cluster.Said();

  cluster.launcher().Signal(SIGINT);
  cluster.WaitForEnd(60);
  std::optional<ExitStatus> ended;
  EXPECT_TRUE(Eventually([&] { return (ended = first->TryWait()).has_value(); }, std::chrono::seconds(60)));
  EXPECT_TRUE(ended && ended->success()) << FileText(LogOf("first"));
  EXPECT_THAT(FileText(LogOf("first")), HasSubstr("the run has ended"));
}

}  // namespace
}  // namespace dadrl
