// The executable itself, over real DDS, with the replay's end of the wire in the test.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <thread>

#include "common/config/config_yaml.h"
#include "common/io/atomic_file.h"
#include "common/io/read_file.h"
#include "common/io/run_key.h"
#include "common/model/policy_file.h"
#include "learner/checkpoint_store.h"
#include "tests/common/dds/dds_fixture.h"
#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/common/io/test_run_key.h"
#include "tests/learner/cluster_fixture.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

constexpr uint64_t kNoLimit = uint64_t{1} << 24;

// A child process; its standard error goes to a file.
class Process {
 public:
  Process(std::vector<std::string> arguments, const std::filesystem::path& log) {
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 2, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    if (posix_spawn(&pid_, argv[0], &actions, nullptr, argv.data(), environ) != 0) pid_ = -1;
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Process() {
    if (pid_ > 0) {
      Signal(SIGKILL);
      Wait();
    }
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void Signal(int signal) const { kill(pid_, signal); }
  // Exit code, or minus the signal that ended it.
  int Wait() {
    int status = 0;
    if (waitpid(std::exchange(pid_, -1), &status, 0) < 0) return -1000;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

 private:
  pid_t pid_ = -1;
};

class LearnerProcessTest : public testing::Test {
 protected:
  LearnerProcessTest() {
    config_.cluster = dds::LoopbackCluster();
    config_.algorithm.batch_size = 16;
    config_.algorithm.n_step = 2;  // as the shard answers
    config_.model.hidden = 16;
    config_.learner.publish_interval_s = 0.05;
    config_.learner.checkpoint_interval_s = 1.0;
    config_.telemetry.interval_s = 0.1;
  }
  ~LearnerProcessTest() override { StopShard(); }

  std::unique_ptr<Process> Start(bool resume = false) {
    EXPECT_TRUE(WriteFileAtomically(folder_.path() / "config.yaml", ToYaml(config_, false)));
    GiveKey();
    std::vector<std::string> arguments = {DADRL_BINARY_DIR "/bin/dadrl-learner", "--config",
                                          (folder_.path() / "config.yaml").string(), "--run-dir",
                                          (folder_.path() / "run").string()};
    if (resume) arguments.push_back("--resume");
    return std::make_unique<Process>(arguments, log_);
  }
  std::string Log() const { return ReadTextFile(log_, kNoLimit).value(); }
  void GiveKey() const {
    const auto run = folder_.path() / "run";
    std::filesystem::create_directories(run);
    if (!std::filesystem::exists(RunKeyFile(run))) EXPECT_TRUE(SaveRunKey(run, kTestRunKey));
  }
  std::filesystem::path Checkpoints() const { return folder_.path() / "run" / "checkpoints"; }

  // A shard that answers every request at once, and an actor that listens to the weights.
  void StartShard() {
    serving_ = true;
    shard_ = std::thread([this] {
      const auto replay = dds::Node::Create(config_.cluster, 1, dds::Role::kReplay, 0, kTestRunKey).value();
      TestShard shard(*replay, 0);
      const auto actor = dds::Node::Create(config_.cluster, 1, dds::Role::kActor, 0, kTestRunKey).value();
      const auto weights = Reader<dadrl_idl_Weights>::Create(*actor, kWeightsTopic).value();
      while (serving_) {
        for (const auto& request : shard.TakeRequests()) {
          // What cannot be sent is asked for again.
          static_cast<void>(
              shard.Reply(request.learner, request.request, maker_.Make(16, request.request, newest_)));
        }
        weights->Take(10, [&](const dadrl_idl_Weights& sample) {
          went_back_ = went_back_ || sample.version <= newest_;
          newest_ = sample.version;
        });
        std::this_thread::sleep_for(1ms);
      }
    });
  }
  void StopShard() {
    serving_ = false;
    if (shard_.joinable()) shard_.join();
  }

  TemporaryFolder folder_;
  const std::filesystem::path log_ = folder_.path() / "learner.log";
  Config config_;
  const BatchMaker maker_{DrivingShape{}};
  std::thread shard_;
  std::atomic<bool> serving_{false};
  std::atomic<bool> went_back_{false};  // a version came that was not newer than the one before
  std::atomic<uint32_t> newest_{0};     // version that the actor has
};

TEST_F(LearnerProcessTest, TrainsPublishesAndLeavesACheckpointWhenTerminated) {
  // An earlier start, by a clock that ran far ahead.
  const auto incarnation = folder_.path() / "run" / "incarnations" / "learner";
  std::filesystem::create_directories(incarnation.parent_path());
  ASSERT_TRUE(WriteFileAtomically(incarnation, "9000000000000000000\n"));
  StartShard();
  const auto learner = Start();
  ASSERT_TRUE(Eventually([&] { return newest_ >= 5; }, std::chrono::seconds(60))) << Log();
  learner->Signal(SIGTERM);
  EXPECT_EQ(learner->Wait(), 0) << Log();
  const auto policy = LoadPolicy(Checkpoints() / "latest");
  ASSERT_TRUE(policy) << policy.error().message;
  EXPECT_GT(policy->updates, 0u);
  EXPECT_GE(policy->policy_version, newest_);
  EXPECT_EQ(policy->config.model.hidden, 16);
  const std::string table = ReadTextFile(folder_.path() / "run" / "logs" / "training.csv", kNoLimit).value();
  EXPECT_GE(std::count(table.begin(), table.end(), '\n'), 2);
  EXPECT_FALSE(std::filesystem::is_empty(folder_.path() / "run" / "tensorboard"));
  EXPECT_EQ(std::stoull(ReadTextFile(incarnation, kNoLimit).value()), 9'000'000'000'000'000'001U);
}

TEST_F(LearnerProcessTest, KilledLearnerGoesOnFromItsCheckpointAndNeverReusesAVersion) {
  StartShard();
  uint64_t updates = 0;
  for (int life = 0; life < 3; ++life) {
    const auto learner = Start(life > 0);
    const uint32_t before = newest_;
    ASSERT_TRUE(Eventually(
        [&] {
          const auto policy = LoadPolicy(Checkpoints() / "latest");
          return newest_ >= before + 10 && policy && policy->updates > updates;
        },
        std::chrono::seconds(60)))
        << Log();
    learner->Signal(SIGKILL);
    EXPECT_EQ(learner->Wait(), -SIGKILL);
    updates = LoadPolicy(Checkpoints() / "latest")->updates;
  }
  EXPECT_FALSE(went_back_);
  EXPECT_THAT(Log(), HasSubstr("resumed"));
}

TEST_F(LearnerProcessTest, StopsByItselfAtMaxUpdates) {
  config_.learner.max_updates = 7;
  StartShard();
  const auto learner = Start();
  EXPECT_EQ(learner->Wait(), 0) << Log();
  EXPECT_EQ(LoadPolicy(Checkpoints() / "latest")->updates, 7u);
}

TEST_F(LearnerProcessTest, TerminatedWhileItWaitsForAReplayLeavesAtOnce) {
  const auto learner = Start();
  ASSERT_TRUE(Eventually([&] { return std::filesystem::exists(folder_.path() / "run" / "tensorboard"); },
                         std::chrono::seconds(60)));
  learner->Signal(SIGTERM);
  EXPECT_EQ(learner->Wait(), 0) << Log();
}

TEST_F(LearnerProcessTest, OnADiskThatIsFullFromItsStartOnItTrainsAndItsLastCheckpointWaitsForRoom) {
  const SmallDisk disk(folder_.path() / "run", "8m");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  GiveKey();
  disk.Fill();
  config_.learner.max_updates = 30;
  StartShard();
  const auto learner = Start();
  ASSERT_TRUE(Eventually([&] { return Log().find("the last checkpoint") != std::string::npos; },
                         std::chrono::seconds(60)))
      << Log();
  EXPECT_THAT(Log(), HasSubstr("training goes on without its curves"));
  EXPECT_THAT(Log(), HasSubstr("actors go on with the policy they have")) << "no version was reserved";
  EXPECT_EQ(newest_, 0u);
  disk.Free();
  EXPECT_EQ(learner->Wait(), 0) << Log();
  EXPECT_EQ(LoadPolicy(Checkpoints() / "latest")->updates, 30u);
}

TEST_F(LearnerProcessTest, KilledOnAFullDiskItGoesOnFromItsCheckpointAndUsesNoVersionTwice) {
  const SmallDisk disk(folder_.path() / "run", "32m");  // room for several checkpoints of 5 MB
  ASSERT_TRUE(disk.mounted()) << disk.why();
  StartShard();
  {
    const auto learner = Start();
    ASSERT_TRUE(Eventually([&] { return std::filesystem::exists(Checkpoints() / "latest"); },
                           std::chrono::seconds(60)))
        << Log();
    disk.Fill();
    const uint32_t before = newest_;
    // Beyond what was reserved in advance.
    ASSERT_TRUE(Eventually([&] { return newest_ > before + 40; }, std::chrono::seconds(60))) << Log();
  }
  const uint32_t before = newest_;
  const auto learner = Start(true);
  ASSERT_TRUE(Eventually([&] { return newest_ > before + 5; }, std::chrono::seconds(60))) << Log();
  EXPECT_FALSE(went_back_);
  EXPECT_THAT(Log(), HasSubstr("resumed"));
  disk.Free();
  learner->Signal(SIGTERM);
  EXPECT_EQ(learner->Wait(), 0) << Log();
}

TEST_F(LearnerProcessTest, BadInputIsOneLineAndItsExitCode) {
  config_.learner.max_updates = 2;
  StartShard();
  ASSERT_EQ(Start()->Wait(), 0) << Log();

  EXPECT_EQ(Start()->Wait(), 2);
  EXPECT_THAT(Log(), HasSubstr("continue it with --resume"));

  config_.model.hidden = 32;
  EXPECT_EQ(Start(true)->Wait(), 2);
  EXPECT_THAT(Log(), HasSubstr("model.hidden (there 16, now 32)"));
  config_.model.hidden = 16;

  const auto checkpoint =
      CheckpointStore::Open(Checkpoints(), {.checkpoints = 3, .policies = 3})->LoadNewest().value()->path;
  std::filesystem::resize_file(checkpoint, 100);
  EXPECT_EQ(Start(true)->Wait(), 1);
  EXPECT_THAT(Log(), HasSubstr("damaged"));
  EXPECT_THAT(Log(), HasSubstr(checkpoint.string()));
}

TEST_F(LearnerProcessTest, WrongUsageIsExitCodeTwo) {
  const std::string program = DADRL_BINARY_DIR "/bin/dadrl-learner";
  EXPECT_EQ(Process({program}, log_).Wait(), 2);
  EXPECT_EQ(Process({program, "--config", "/absent.yaml", "--run-dir", "/tmp", "--what"}, log_).Wait(), 2);
  const auto config = folder_.path() / "config.yaml";
  ASSERT_TRUE(WriteFileAtomically(config, "algorithm:\n  gama: 0.9\n"));
  EXPECT_EQ(
      Process({program, "--config", config.string(), "--run-dir", folder_.path().string()}, log_).Wait(), 2);
  EXPECT_THAT(Log(), HasSubstr("algorithm.gamma"));
}

TEST_F(LearnerProcessTest, WithADamagedKeyItDoesNotTakePart) {
  std::filesystem::create_directories(folder_.path() / "run");
  ASSERT_TRUE(WriteFileAtomically(RunKeyFile(folder_.path() / "run"), "short\n"));
  EXPECT_EQ(Start()->Wait(), 1) << Log();
  EXPECT_THAT(Log(), HasSubstr("holds no key of a run"));
  EXPECT_THAT(Log(), HasSubstr("put the file back"));
  EXPECT_FALSE(std::filesystem::exists(Checkpoints()));
}

TEST_F(LearnerProcessTest, ASecondLearnerOfTheClusterIsRefusedBeforeItTouchesTheRun) {
  StartShard();
  const auto first = Start();
  ASSERT_TRUE(Eventually([&] { return newest_ >= 1; }, std::chrono::seconds(60))) << Log();
  const auto other_log = folder_.path() / "second.log";
  Process second(
      {DADRL_BINARY_DIR "/bin/dadrl-learner", "--config", (folder_.path() / "config.yaml").string(),
       "--run-dir", (folder_.path() / "run").string(), "--resume"},
      other_log);
  EXPECT_EQ(second.Wait(), 1);
  EXPECT_THAT(ReadTextFile(other_log, kNoLimit).value(), HasSubstr("port"));
}

}  // namespace
}  // namespace dadrl
