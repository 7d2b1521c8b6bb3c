#include "deploy/monitor/supervision.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include "deploy/monitor/merge_supervision.h"
#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

SupervisedProcess Process(const std::string& name, pid_t pid, const std::string& trouble = "") {
  SupervisedProcess process;
  process.name = name;
  process.pid = pid;
  process.state = "running";
  process.trouble = trouble;
  return process;
}

TEST(Supervision, ComesBackFromItsFile) {
  const TemporaryFolder folder;
  Supervision supervision{.launcher = 17, .processes = {Process("replay-0", 18, "silent for 3 s \"x\"")}};
  supervision.processes[0].restarts = 2;
  supervision.processes[0].hangs = 1;
  supervision.processes[0].last_end = "it hung";
  ASSERT_TRUE(SaveSupervision(folder.path() / "processes.json", supervision));
  const auto loaded = LoadSupervision(folder.path() / "processes.json");
  ASSERT_TRUE(loaded);
  EXPECT_EQ(*loaded, supervision);
}

TEST(Supervision, RefusesWhatIsNone) {
  EXPECT_FALSE(ParseSupervision(""));
  EXPECT_FALSE(ParseSupervision("[]"));
  EXPECT_FALSE(ParseSupervision(R"({"launcher": "x", "processes": []})"));
  EXPECT_FALSE(ParseSupervision(R"({"launcher": 1, "processes": [{"name": 3}]})"));
  EXPECT_FALSE(ParseSupervision(R"({"launcher": 1, "processes": 7})"));
  EXPECT_FALSE(LoadSupervision("/no/such/processes.json"));
}

TEST(Supervision, OnAFullDiskThereIsNoneRatherThanAnOldOne) {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "64k");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  const auto file = disk.path() / "processes.json";
  ASSERT_TRUE(SaveSupervision(file, {.launcher = 17, .processes = {}}));
  disk.Fill();
  EXPECT_EQ(SaveSupervision(file, {.launcher = 18, .processes = {}}).error().code, ErrorCode::kExhausted);
  EXPECT_FALSE(std::filesystem::exists(file));
  disk.Free();
  ASSERT_TRUE(SaveSupervision(file, {.launcher = 19, .processes = {}}));
  EXPECT_EQ(LoadSupervision(file)->launcher, 19);
}

TEST(Supervision, IsNotWrittenThroughALink) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "mine") << "precious";
  std::filesystem::create_symlink("mine", folder.path() / "processes.json.new");
  EXPECT_FALSE(SaveSupervision(folder.path() / "processes.json", {}));
  std::string text;
  std::ifstream(folder.path() / "mine") >> text;
  EXPECT_EQ(text, "precious");
}

TEST(AddStopped, TellsWhatTheSystemKnowsAndTheLauncherCannot) {
  const TemporaryFolder proc;
  const auto put = [&](pid_t pid, const char* state) {
    std::filesystem::create_directories(proc.path() / std::to_string(pid));
    std::ofstream(proc.path() / std::to_string(pid) / "stat") << pid << " (x) " << state << " 1";
  };
  put(17, "T");
  put(18, "T");
  put(19, "S");
  put(20, "t");  // a debugger holds it
  Supervision supervision{
      .launcher = 17, .processes = {Process("replay-0", 18), Process("learner", 19), Process("actor-0", 20)}};
  AddStopped(supervision, proc.path());
  EXPECT_THAT(supervision.Troubles(),
              ElementsAre("replay-0: stopped by a signal", HasSubstr("launcher: stopped")));
  EXPECT_THAT(supervision.Troubles().back(), HasSubstr("kill -CONT 17"));
}

TEST(MergeSupervision, ShowsAProcessThatWasNeverHeard) {
  ClusterSummary summary;
  summary.processes.push_back({.name = "learner", .role = dds::Role::kLearner, .pid = 5, .restarts = 3});
  SupervisedProcess learner = Process("learner", 5, "silent for 4 s: its thread 'train'");
  learner.hangs = 1;
  learner.restarts = 2;
  MergeSupervision({.launcher = 1,
                    .processes = {learner, Process("replay-1", 6, "starts again"), Process("actor-12", 7),
                                  Process("launcher", 1, "stopped")}},
                   summary);
  ASSERT_EQ(summary.processes.size(), 3u);
  EXPECT_EQ(summary.processes[0].trouble, learner.trouble);
  EXPECT_EQ(summary.processes[0].hangs, 1);
  EXPECT_EQ(summary.processes[0].restarts, 3);
  EXPECT_EQ(summary.processes[1].role, dds::Role::kReplay);
  EXPECT_EQ(summary.processes[1].index, 1);
  EXPECT_TRUE(summary.processes[1].stale);
  EXPECT_EQ(summary.processes[2].index, 12);
  EXPECT_EQ(summary.processes[2].trouble, "not heard");
}

}  // namespace
}  // namespace dadrl
