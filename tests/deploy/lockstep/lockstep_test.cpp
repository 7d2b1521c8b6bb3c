#include "deploy/lockstep/lockstep.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "common/config/config_yaml.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

Config TinyTraining(uint64_t seed) {
  Config config;
  config.seed = seed;
  config.replay.min_size = 200;
  config.learner.max_updates = 60;
  config.learner.publish_interval_s = 10 * kLockstepUpdateSeconds;
  config.model.hidden = 64;
  return config;
}

// A process holds one simulation, so each training gets a process of its own.
Result<LockstepResult> TrainInChild(const Config& config, const fs::path& directory) {
  int ends[2];
  if (pipe(ends) != 0) return Fail(ErrorCode::kInternal, "pipe");
  const pid_t child = fork();
  if (child == 0) {
    const std::atomic<bool> stop{false};
    const auto result = TrainInLockstep(config, directory, stop);
    const bool sent = result && write(ends[1], &*result, sizeof *result) == sizeof *result;
    _exit(sent ? 0 : 1);
  }
  close(ends[1]);
  LockstepResult result;
  const bool received = read(ends[0], &result, sizeof result) == sizeof result;
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!received || status != 0) return Fail(ErrorCode::kInternal, "the training failed");
  return result;
}

TEST(Lockstep, SameSeedGivesTheSameWeightsBitForBit) {
  const auto first = TrainInChild(TinyTraining(5), TemporaryFolder().path());
  const auto second = TrainInChild(TinyTraining(5), TemporaryFolder().path());
  const auto other = TrainInChild(TinyTraining(6), TemporaryFolder().path());
  ASSERT_TRUE(first && second && other);
  EXPECT_EQ(first->updates, 60u);
  EXPECT_GT(first->episodes, 0u);
  EXPECT_EQ(first->decisions, second->decisions);
  EXPECT_EQ(first->policy_hash, second->policy_hash);
  EXPECT_NE(first->policy_hash, other->policy_hash);
}

TEST(Lockstep, OnAllScenariosToo) {
  Config config = TinyTraining(5);
  config.scenario = "all";
  const auto first = TrainInChild(config, TemporaryFolder().path());
  const auto second = TrainInChild(config, TemporaryFolder().path());
  const auto one = TrainInChild(TinyTraining(5), TemporaryFolder().path());
  ASSERT_TRUE(first && second && one);
  EXPECT_EQ(first->policy_hash, second->policy_hash);
  EXPECT_NE(first->policy_hash, one->policy_hash);
}

// Whatever learns: what its preset says beside the name, small.
TEST(Lockstep, OtherNetworksRepeatTheirWeightsToo) {
  Config scene = TinyTraining(5);
  scene.learner.max_updates = 5;
  scene.algorithm.batch_size = 16;
  scene.observation.polylines = scene.model.scene = true;
  scene.model.stae = scene.model.context = false;
  scene.algorithm.name = "mst";
  Config slt = scene;
  slt.algorithm.name = "slt";
  slt.replay.sequence_length = 3;
  Config dt = scene;
  dt.algorithm.name = "dt";
  dt.model.policy = "decision_transformer";
  dt.replay.sequence_length = 20;
  for (const Config& config : {scene, slt, dt}) {
    const auto first = TrainInChild(config, TemporaryFolder().path());
    const auto second = TrainInChild(config, TemporaryFolder().path());
    ASSERT_TRUE(first && second) << config.algorithm.name;
    EXPECT_EQ(first->updates, 5u) << config.algorithm.name;
    EXPECT_EQ(first->policy_hash, second->policy_hash) << config.algorithm.name;
  }
}

// Rollouts come when they are complete, and the first policy before any.
TEST(Lockstep, TrainsOnPolicyToo) {
  Config config = TinyTraining(5);
  ASSERT_TRUE(LoadYaml(DADRL_SOURCE_DIR "/deploy/config/algorithms/ppo.yaml", config));
  config.algorithm.name = "ppo";
  config.algorithm.rollout = 64;
  config.algorithm.epochs = 2;
  config.replay.sequence_length = 8;
  config.replay.sequence_period = 8;
  config.learner.max_updates = 5;
  const auto first = TrainInChild(config, TemporaryFolder().path());
  const auto second = TrainInChild(config, TemporaryFolder().path());
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->updates, 5u);
  EXPECT_EQ(first->policy_hash, second->policy_hash);
}

TEST(Lockstep, RefusesATrainingWithoutAnEnd) {
  Config config = TinyTraining(1);
  config.learner.max_updates = 0;
  const std::atomic<bool> stop{false};
  const auto result = TrainInLockstep(config, TemporaryFolder().path(), stop);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().code, ErrorCode::kInvalidArgument);
}

TEST(Lockstep, RefusesAnEndThatDependsOnTheProcessor) {
  Config config = TinyTraining(1);
  config.learner.max_cpu_seconds = 10.0;
  const std::atomic<bool> stop{false};
  const auto result = TrainInLockstep(config, TemporaryFolder().path(), stop);
  ASSERT_FALSE(result);
  EXPECT_NE(result.error().message.find("learner.max_cpu_seconds: 10"), std::string::npos);
}

TEST(Lockstep, RefusesARunThatHasCheckpoints) {
  const TemporaryFolder folder;
  ASSERT_TRUE(TrainInChild(TinyTraining(2), folder.path()));
  const std::atomic<bool> stop{false};
  const auto again = TrainInLockstep(TinyTraining(2), folder.path(), stop);
  ASSERT_FALSE(again);
  EXPECT_EQ(again.error().code, ErrorCode::kInvalidArgument);
}

}  // namespace
}  // namespace dadrl
