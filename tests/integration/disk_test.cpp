// What disks and limits do to a whole training (docs/reliability.md, "Disks, descriptors, clocks").
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <cstdlib>

#include "common/io/read_file.h"
#include "tests/common/io/small_disk.h"
#include "tests/integration/cluster_under_test.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

std::vector<std::string> LeftTurn(std::vector<std::string> more = {}) {
  std::vector<std::string> arguments = SmallTraining();
  arguments.insert(arguments.begin(), "left_turn");
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

bool HasFault(const json& monitor, const std::string& process, const std::string& kind) {
  return std::ranges::any_of(monitor["faults"], [&](const json& fault) {
    return fault["process"] == process && fault["kind"] == kind;
  });
}

// Another process of that name than `before`, which reports.
bool CameBack(const json& monitor, const std::string& name, pid_t before) {
  const json row = ProcessIn(monitor, name);
  return !row.is_null() && row["pid"] != before && row["stale"] == false;
}

class FullDisk : public testing::Test {
 protected:
  FullDisk() : cluster_(disk_.path(), LeftTurn()) {}
  void SetUp() override {
    ASSERT_TRUE(disk_.mounted()) << disk_.why();
    before_ = Await(IsTraining);
    ASSERT_TRUE(before_);
    ASSERT_TRUE(Eventually([&] { return std::filesystem::exists(disk_.path() / "checkpoints/latest"); }));
  }
  void TearDown() override {
    if (cluster_.launcher().TryWait()) return;
    cluster_.launcher().Signal(SIGINT);
    EXPECT_EQ(cluster_.WaitForEnd(90), 0) << cluster_.Said();
  }
  std::optional<json> Await(const std::function<bool(const json&)>& condition) {
    auto answer = cluster_.MonitorUntil(condition);
    EXPECT_TRUE(answer) << cluster_.Said();
    return answer;
  }
  // Until the replay can store nothing, and says so.
  std::optional<json> FillUp() {
    return Await([&](const json& monitor) {
      disk_.Fill();
      return HasFault(monitor, "replay-0", "experience") && HasFault(monitor, "learner", "training_log");
    });
  }
  // After there is room again.
  void ExpectRecovery() {
    const double updates = cluster_.Monitor().value_or(json{{"updates", 0.0}})["updates"];
    disk_.Free();
    ASSERT_TRUE(Await([&](const json& monitor) {
      return IsTraining(monitor) && monitor["updates"] > updates + 20 && monitor["faults"].empty();
    }));
    ASSERT_TRUE(Eventually([&] {
      return cluster_.Said().find("replay-0: experience can be stored again") != std::string::npos;
    })) << cluster_.Said();
  }

  TemporaryFolder folder_;
  const SmallDisk disk_{folder_.path() / "run", "64m"};  // checkpoints alone take 21 MB
  ClusterUnderTest cluster_;
  std::optional<json> before_;
};

TEST_F(FullDisk, IsSaidWhereverPeopleLookRestartsNobodyAndPasses) {
  const auto full = FillUp();
  ASSERT_TRUE(full);
  EXPECT_THAT((*full)["bottleneck"].get<std::string>(), HasSubstr("replay-0: cannot"));
  EXPECT_THAT((*full)["bottleneck"].get<std::string>(), HasSubstr("No space left on device"));
  // The launcher looks twice a second.
  for (const char* said : {"fault of replay-0: cannot", "fault of learner: cannot"}) {
    EXPECT_TRUE(Eventually([&] { return cluster_.Said().find(said) != std::string::npos; }))
        << said << cluster_.Said();
  }
  for (const char* name : {"learner", "replay-0", "actor-0"}) {
    EXPECT_EQ(PidOf(*full, name), PidOf(*before_, name)) << name << " was restarted";
  }
  ExpectRecovery();
  cluster_.launcher().Signal(SIGINT);
  ASSERT_EQ(cluster_.WaitForEnd(90), 0) << cluster_.Said();
  EXPECT_THAT(cluster_.Said(), HasSubstr("faults of this session: "));
  const json results = json::parse(ReadTextFile(disk_.path() / "results.json", 1 << 24).value());
  EXPECT_THAT(results["lost_s"].dump(), HasSubstr("replay-0: cannot")) << "the time is counted as lost";
}

TEST_F(FullDisk, AndEachProcessKilledMeanwhileComesBackAndNoVersionIsUsedTwice) {
  ASSERT_TRUE(FillUp());
  for (const char* name : {"replay-0", "learner", "actor-0"}) {
    const auto now = Await([&](const json& monitor) { return PidOf(monitor, name) > 0; });
    ASSERT_TRUE(now);
    const pid_t victim = PidOf(*now, name);
    const double version = (*now)["weights_version"];
    const double frames = (*now)["replay_frames"];
    ASSERT_EQ(kill(victim, SIGKILL), 0);
    ASSERT_TRUE(Await([&](const json& monitor) {
      disk_.Fill();
      return CameBack(monitor, name, victim) && monitor["weights_version"] >= version &&
             monitor["replay_frames"] >= frames;
    })) << name;
  }
  ExpectRecovery();
}

// Of this process and what it starts.
class DescriptorLimit {
 public:
  explicit DescriptorLimit(rlim_t count) {
    getrlimit(RLIMIT_NOFILE, &before_);
    const rlimit limit{count, before_.rlim_max};
    setrlimit(RLIMIT_NOFILE, &limit);
  }
  ~DescriptorLimit() { setrlimit(RLIMIT_NOFILE, &before_); }
  DescriptorLimit(const DescriptorLimit&) = delete;
  DescriptorLimit& operator=(const DescriptorLimit&) = delete;

 private:
  rlimit before_{};
};

TEST(Descriptors, ASmallTableOfThemTrainsWithManySegments) {
  const TemporaryFolder folder;
  std::optional<ClusterUnderTest> cluster;
  {
    const DescriptorLimit few(128);
    cluster.emplace(folder.path() / "run", LeftTurn({"--set", "replay.segment_bytes=65536", "--set",
                                                     "replay.max_disk_bytes=1073741824"}));
  }
  const auto segments = [&] {
    std::error_code error;
    return std::distance(std::filesystem::directory_iterator(cluster->run() / "replay/shard-0", error), {});
  };
  const auto much =
      cluster->MonitorUntil([&](const json& monitor) { return IsTraining(monitor) && segments() > 40; });
  ASSERT_TRUE(much) << cluster->Said();
  EXPECT_TRUE((*much)["faults"].empty()) << (*much)["faults"];
  const std::filesystem::directory_iterator open(fmt::format("/proc/{}/fd", PidOf(*much, "replay-0")));
  EXPECT_LT(std::distance(open, {}), 60) << "none for a segment";
  cluster->launcher().Signal(SIGINT);
  EXPECT_EQ(cluster->WaitForEnd(60), 0) << cluster->Said();
}

TEST(NoSymbolicLinks, ATrainingEndsWellAndItsPoliciesAreFoundByTheSameNames) {
  const TemporaryFolder folder;
  setenv("LD_PRELOAD", DADRL_BINARY_DIR "/tests/no_symlink.so", 1);
  ClusterUnderTest cluster(folder.path() / "run", LeftTurn({"--set", "learner.max_updates=60"}));
  unsetenv("LD_PRELOAD");
  ASSERT_EQ(cluster.WaitForEnd(120), 0) << cluster.Said();
  EXPECT_THAT(cluster.Said(), Not(HasSubstr("starting it again")));
  for (const char* name : {"latest", "best"}) {
    const auto policy = cluster.run() / "checkpoints" / name;
    EXPECT_FALSE(std::filesystem::is_symlink(policy)) << name;
    const CommandOutput output =
        Dadrl({"evaluate", "--policy", policy, "--episodes", "1", "--seeds", "1", "--json"});
    EXPECT_EQ(output.exit_code, 0) << name << ": " << output.err;
  }
}

TEST(ReadOnlyFolder, IsRefusedInOneLineBeforeAnythingStarts) {
  const TemporaryFolder folder;
  const SmallDisk disk(folder.path() / "disk", "1m");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  ASSERT_TRUE(disk.MakeReadOnly());
  for (const auto& run : {disk.path(), disk.path() / "run"}) {
    const CommandOutput output = Dadrl({"train", "left_turn", "--run-dir", run});
    EXPECT_GE(output.exit_code, 1);
    EXPECT_EQ(std::ranges::count(output.err, '\n'), 1) << output.err;
    EXPECT_THAT(output.err, HasSubstr("ead-only file system"));
    EXPECT_THAT(output.err, HasSubstr(run.string()));
  }
}

}  // namespace
}  // namespace dadrl
