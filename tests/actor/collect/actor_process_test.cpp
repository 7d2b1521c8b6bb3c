// The real program on the real simulator over real DDS; only the replay is the test's own.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <cmath>
#include <fstream>
#include <sstream>

#include "common/config/config_yaml.h"
#include "common/dds/node.h"
#include "common/io/checksum.h"
#include "common/io/run_key.h"
#include "common/model/policy_model.h"
#include "proto/evaluation/episode_line.h"
#include "proto/telemetry.h"
#include "tests/actor/experience/replay_peer.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/common/io/test_run_key.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

constexpr const char* kProgram = DADRL_BINARY_DIR "/bin/dadrl-actor";

// A child with its standard error in a file; killed when it is still there at the end.
class Program {
 public:
  Program(std::vector<std::string> arguments, const std::filesystem::path& log) {
    arguments.insert(arguments.begin(), kProgram);
    std::vector<char*> pointers;
    for (std::string& argument : arguments) pointers.push_back(argument.data());
    pointers.push_back(nullptr);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_addopen(&actions, 2, log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0644);
    EXPECT_EQ(::posix_spawn(&pid_, kProgram, &actions, nullptr, pointers.data(), environ), 0);
    posix_spawn_file_actions_destroy(&actions);
  }
  ~Program() {
    if (pid_ > 0) Kill();
  }
  void Kill() {
    ::kill(pid_, SIGKILL);
    Wait();
  }
  void Terminate() { ::kill(pid_, SIGTERM); }
  // Exit code, or 128 and the signal's number.
  int Wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_ = 0;
};

class ActorProcessTest : public ::testing::Test {
 protected:
  ActorProcessTest() {
    config_.cluster.port = dds::FindFreePort().value();
    config_.actor.chunk_frames = 8;
    config_.telemetry.interval_s = 0.1;
    SaveConfig();
    EXPECT_TRUE(SaveRunKey(root_, kTestRunKey));
  }
  void SaveConfig() { std::ofstream(root_ / "config.yaml") << ToYaml(config_, false); }
  std::vector<std::string> Arguments() const {
    return {"collect", "--config", root_ / "config.yaml", "--run-dir", root_, "--index", "0"};
  }
  Program Start() { return Program(Arguments(), Log()); }
  std::filesystem::path Log() const { return root_ / "actor.log"; }
  std::string Read(const std::filesystem::path& path) const {
    std::ostringstream text;
    text << std::ifstream(path).rdbuf();
    return text.str();
  }
  void PublishPolicy(uint32_t version, uint64_t other_layout = 0) {
    if (!learner_) {
      learner_ = dds::Node::Create(config_.cluster, 1, dds::Role::kLearner, 0, kTestRunKey).value();
      weights_ = Writer<dadrl_idl_Weights>::Create(*learner_, kWeightsTopic).value();
    }
    const auto policy = MakePolicyModel(DrivingShape::From(config_.observation), config_.model).value();
    std::vector<float> parameters(policy->layout().size());
    dadrl_idl_Weights message{};
    message.version = version;
    message.published_ns = WallTimeNs();
    message.layout_hash = policy->layout().hash() ^ other_layout;
    message.checksum = Xxh3(std::as_bytes(std::span(parameters)));
    message.parameters._buffer = reinterpret_cast<uint8_t*>(parameters.data());
    message.parameters._length = static_cast<uint32_t>(parameters.size() * sizeof(float));
    message.parameters._maximum = message.parameters._length;
    ASSERT_TRUE(weights_->Write(message));
  }

  const TemporaryFolder folder_;
  const std::filesystem::path root_ = folder_.path();
  Config config_;
  ReplayDisk disk_;
  std::unique_ptr<dds::Node> learner_;
  std::unique_ptr<Writer<dadrl_idl_Weights>> weights_;
};

TEST_F(ActorProcessTest, SendsExperienceAndLeavesNothingUnsentOnSigterm) {
  // An earlier start, by a clock that ran far ahead.
  const auto incarnation = root_ / "incarnations" / "actor-0";
  std::filesystem::create_directories(incarnation.parent_path());
  std::ofstream(incarnation) << "9000000000000000000\n";
  RunningReplayPeer replay(config_.cluster, disk_, 1000);
  auto telemetry = TelemetrySubscriber::Create(TelemetryUrl(config_.cluster));
  Program actor = Start();
  ASSERT_TRUE(Eventually([&] { return disk_.stored() >= 10; }, std::chrono::seconds(90))) << Read(Log());
  PublishPolicy(1);
  ASSERT_TRUE(Eventually([&] { return replay->newest_policy_version() == 1; }, std::chrono::seconds(90)))
      << Read(Log());
  if (telemetry) {
    ProcessStatus last;
    EXPECT_TRUE(Eventually([&] {
      (*telemetry)
          ->Poll(std::chrono::milliseconds(20), [&](const ProcessStatus& status) { last = status; }, {});
      return last[Metric::kPolicyVersion] == 1 && last[Metric::kDecisions] > 80;
    }));
    EXPECT_GE(last[Metric::kEnvSteps], last[Metric::kDecisions]);
    EXPECT_GT(last.activities[Activity::kWaitForSimulator].seconds, 0.0);
  }
  actor.Terminate();
  EXPECT_EQ(actor.Wait(), 0);
  EXPECT_THAT(Read(Log()), ::testing::Not(HasSubstr("not acknowledged")));
  EXPECT_EQ(std::stoull(Read(incarnation)), 9'000'000'000'000'000'001U);
  const auto chunks = disk_.Copy();
  EXPECT_EQ(chunks.size(), replay->highest_seen());
  for (const auto& chunk : chunks) {
    for (const float reward : chunk.rewards) EXPECT_TRUE(std::isfinite(reward));
  }
}

TEST_F(ActorProcessTest, DrivesOnWithItsPolicyWhenTheLearnerIsGone) {
  RunningReplayPeer replay(config_.cluster, disk_, 1000);
  Program actor = Start();
  ASSERT_TRUE(Eventually([&] { return disk_.stored() >= 1; }, std::chrono::seconds(90))) << Read(Log());
  PublishPolicy(7);
  ASSERT_TRUE(Eventually([&] { return replay->newest_policy_version() == 7; }, std::chrono::seconds(90)))
      << Read(Log());
  weights_.reset();
  learner_.reset();
  const uint64_t before = disk_.stored();
  EXPECT_TRUE(Eventually([&] { return disk_.stored() >= before + 20; }, std::chrono::seconds(90)))
      << Read(Log());
  EXPECT_EQ(replay->last_policy_version(), 7u);
  actor.Terminate();
  EXPECT_EQ(actor.Wait(), 0) << Read(Log());
}

TEST_F(ActorProcessTest, GoesOnAfterTheReplayWasAway) {
  Program actor = Start();
  EXPECT_TRUE(Eventually(
      [&] { return Read(Log()).find("waiting for the replay at 127.0.0.1:") != std::string::npos; },
      std::chrono::seconds(90)));
  for (int round = 1; round <= 2; ++round) {
    RunningReplayPeer replay(config_.cluster, disk_, 1000);
    const uint64_t before = disk_.stored();
    EXPECT_TRUE(Eventually([&] { return disk_.stored() >= before + 5; }, std::chrono::seconds(90)))
        << Read(Log());
  }
  actor.Kill();
}

TEST_F(ActorProcessTest, ARestartedActorDrivesOtherTraffic) {
  RunningReplayPeer replay(config_.cluster, disk_, 1000);
  const auto log = root_ / "logs" / "episodes-actor-0.csv";
  const auto rows = [&] {
    const std::string text = Read(log);
    return std::count(text.begin(), text.end(), '\n') - 1;
  };
  for (int start = 1; start <= 2; ++start) {
    const auto before = std::max<std::ptrdiff_t>(rows(), 0);  // the first may have driven several
    Program actor = Start();
    EXPECT_TRUE(Eventually([&] { return rows() > before; }, std::chrono::seconds(90))) << Read(Log());
    actor.Kill();
  }
  std::set<std::string> seeds;
  std::set<std::string> incarnations;
  std::istringstream lines(Read(log));
  std::string line;
  std::getline(lines, line);
  uint64_t episodes = 0;
  for (uint64_t last = 0; std::getline(lines, line); ++episodes) {
    std::istringstream fields(line);
    std::string field[4];
    for (std::string& text : field) std::getline(fields, text, ',');
    incarnations.insert(field[1]);
    EXPECT_GT(std::stoull(field[2]), last) << "the numbers go on";
    last = std::stoull(field[2]);
    seeds.insert(field[3]);
    EXPECT_LT(std::stoull(field[3]), kFirstEvaluationSeed);
  }
  EXPECT_EQ(incarnations.size(), 2);
  EXPECT_EQ(seeds.size(), episodes);
}

TEST_F(ActorProcessTest, SaysThatItsConfigurationIsNotTheLearners) {
  RunningReplayPeer replay(config_.cluster, disk_, 1000);
  PublishPolicy(1, 0xff);
  Program actor = Start();
  EXPECT_EQ(actor.Wait(), 2);
  EXPECT_THAT(Read(Log()), HasSubstr("another network than this actor's configuration"));
}

TEST_F(ActorProcessTest, RefusesAnUnknownScenarioInOneLine) {
  config_.scenario = "left_trun";
  SaveConfig();
  Program actor = Start();
  EXPECT_EQ(actor.Wait(), 2);
  const std::string log = Read(Log());
  EXPECT_THAT(log, HasSubstr("left_turn"));
  EXPECT_EQ(std::count(log.begin(), log.end(), '\n'), 1);
}

TEST_F(ActorProcessTest, RefusesWrongUsage) {
  EXPECT_EQ(Program({}, Log()).Wait(), 2);
  EXPECT_EQ(Program({"collect", "--index", "0"}, Log()).Wait(), 2);
  EXPECT_EQ(Program({"evaluate", "--policy", "rdm", "--seeds", "7"}, Log()).Wait(), 2);
}

TEST_F(ActorProcessTest, RefusesToEvaluateOnTheTrafficOfTraining) {
  EXPECT_EQ(Program({"evaluate", "--policy", "rdm", "--seeds", "999999:1"}, Log()).Wait(), 2);
  EXPECT_THAT(Read(Log()),
              HasSubstr("--seeds: 999999 belongs to training; evaluation takes seeds from 1000000 up"));
}

TEST_F(ActorProcessTest, RefusesAnotherDriversOptions) {
  EXPECT_EQ(
      Program({"evaluate", "--policy", "rdm", "--seeds", "1000000:1", "--impatience", "0.5"}, Log()).Wait(),
      2);
  EXPECT_THAT(Read(Log()), HasSubstr("--impatience is for --policy idm, not for rdm"));
}

TEST_F(ActorProcessTest, WithoutTheRunsKeyItDoesNotTakePart) {
  std::filesystem::remove(RunKeyFile(root_));
  EXPECT_EQ(Start().Wait(), 1) << Read(Log());
  EXPECT_THAT(Read(Log()), HasSubstr(RunKeyFile(root_).string()));
  EXPECT_THAT(Read(Log()), HasSubstr("dadrl train --resume"));
}

}  // namespace
}  // namespace dadrl
