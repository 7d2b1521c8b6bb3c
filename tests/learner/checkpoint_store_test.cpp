#include "learner/checkpoint_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "common/config/config_yaml.h"
#include "common/io/atomic_file.h"
#include "common/io/read_file.h"
#include "common/model/policy_file.h"
#include "tests/common/io/small_disk.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/learner/fake_algorithm.h"

namespace dadrl {
namespace {

using testing::ElementsAre;

Checkpoint CheckpointAt(uint64_t updates, size_t parameters = 200) {
  FakeAlgorithm algorithm(parameters, updates);
  Checkpoint checkpoint;
  CaptureState(algorithm, checkpoint);
  checkpoint.updates = updates;
  checkpoint.weights_version = static_cast<uint32_t>(updates / 10);
  checkpoint.config_yaml = ToYaml(Config(), false);
  return checkpoint;
}

void Damage(const std::filesystem::path& path) {
  std::vector<std::byte> bytes = ReadFile(path, 1 << 24).value();
  bytes[bytes.size() / 2] ^= std::byte{1};
  ASSERT_TRUE(WriteFileAtomically(path, bytes));
}

class CheckpointStoreTest : public testing::Test {
 protected:
  CheckpointStore Open(Retention kept = {.checkpoints = 2, .policies = 2}) {
    return CheckpointStore::Open(folder_.path(), kept).value();
  }
  std::vector<std::string> Names() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryFolder folder_;
};

TEST_F(CheckpointStoreTest, KeepsTheNewestWithTheirPoliciesAndALinkToTheLast) {
  CheckpointStore store = Open();
  for (const uint64_t updates : {10u, 20u, 30u}) ASSERT_TRUE(store.Save(CheckpointAt(updates)));
  EXPECT_THAT(Names(), ElementsAre("checkpoint-000000020.ckpt", "checkpoint-000000030.ckpt", "latest",
                                   "policy-000000020.dadrl", "policy-000000030.dadrl"));
  const auto policy = LoadPolicy(folder_.path() / "latest");
  ASSERT_TRUE(policy) << policy.error().message;
  EXPECT_EQ(policy->updates, 30u);
  EXPECT_EQ(policy->policy_version, 3u);
}

TEST_F(CheckpointStoreTest, AFullDiskKeepsTheLastCheckpointAndIsNotFilledUpWithAttempts) {
  const SmallDisk disk(folder_.path() / "disk", "256k");
  ASSERT_TRUE(disk.mounted()) << disk.why();
  CheckpointStore store = CheckpointStore::Open(disk.path(), {.checkpoints = 2, .policies = 2}).value();
  ASSERT_TRUE(store.Save(CheckpointAt(10)));
  // Room for a policy, not for the checkpoint that belongs to it.
  const uint64_t before = std::filesystem::space(disk.path()).free;
  for (uint64_t updates = 20; updates < 100; updates += 10) {
    const Status saved = store.Save(CheckpointAt(updates, 16000));
    ASSERT_FALSE(saved);
    EXPECT_EQ(saved.error().code, ErrorCode::kExhausted);
  }
  EXPECT_EQ(std::filesystem::space(disk.path()).free, before);
  EXPECT_EQ(store.LoadNewest().value()->checkpoint.updates, 10u);
  EXPECT_EQ(LoadPolicy(disk.path() / "latest")->updates, 10u);
  ASSERT_TRUE(store.Save(CheckpointAt(100)));
  EXPECT_EQ(store.LoadNewest().value()->checkpoint.updates, 100u);
}

TEST_F(CheckpointStoreTest, KeepsMorePoliciesThanCheckpoints) {
  CheckpointStore store = Open({.checkpoints = 1, .policies = 3});
  for (const uint64_t updates : {10u, 20u, 30u, 40u}) ASSERT_TRUE(store.Save(CheckpointAt(updates)));
  EXPECT_THAT(Names(), ElementsAre("checkpoint-000000040.ckpt", "latest", "policy-000000020.dadrl",
                                   "policy-000000030.dadrl", "policy-000000040.dadrl"));
}

TEST_F(CheckpointStoreTest, KeepsAsManyPoliciesAsTrainingsEndChoosesFrom) {
  Config config;
  config.learner.checkpoints_kept = 3;
  config.evaluation.candidates = 8;
  EXPECT_EQ(Retention::Of(config).checkpoints, 3);
  EXPECT_EQ(Retention::Of(config).policies, 8);
  config.evaluation.candidates = 1;
  EXPECT_EQ(Retention::Of(config).policies, 3);
}

TEST_F(CheckpointStoreTest, NothingToLoadInANewFolder) {
  EXPECT_TRUE(Open().empty());
  const auto loaded = Open().LoadNewest();
  ASSERT_TRUE(loaded);
  EXPECT_FALSE(loaded->has_value());
}

TEST_F(CheckpointStoreTest, DamagedNewestIsSetAsideAndTheOneBeforeIsTaken) {
  CheckpointStore store = Open({.checkpoints = 3, .policies = 3});
  for (const uint64_t updates : {10u, 20u, 30u}) ASSERT_TRUE(store.Save(CheckpointAt(updates)));
  Damage(folder_.path() / "checkpoint-000000030.ckpt");
  auto loaded = store.LoadNewest();
  ASSERT_TRUE(loaded) << loaded.error().message;
  ASSERT_TRUE(loaded->has_value());
  EXPECT_EQ((*loaded)->checkpoint.updates, 20u);
  EXPECT_TRUE(std::filesystem::exists(folder_.path() / "checkpoint-000000030.ckpt.corrupt"));
  // The next checkpoint removes the policy that training went back behind.
  ASSERT_TRUE(store.Save(CheckpointAt(25)));
  EXPECT_THAT(Names(),
              ElementsAre("checkpoint-000000010.ckpt", "checkpoint-000000020.ckpt",
                          "checkpoint-000000025.ckpt", "checkpoint-000000030.ckpt.corrupt", "latest",
                          "policy-000000010.dadrl", "policy-000000020.dadrl", "policy-000000025.dadrl"));
}

TEST_F(CheckpointStoreTest, AllDamagedIsAnErrorNotANewBeginning) {
  CheckpointStore store = Open();
  ASSERT_TRUE(store.Save(CheckpointAt(10)));
  Damage(folder_.path() / "checkpoint-000000010.ckpt");
  const auto loaded = store.LoadNewest();
  ASSERT_FALSE(loaded);
  EXPECT_EQ(loaded.error().code, ErrorCode::kCorrupt);
}

TEST_F(CheckpointStoreTest, FailedSaveKeepsTheEarlierCheckpoints) {
  CheckpointStore store = Open({.checkpoints = 1, .policies = 1});
  ASSERT_TRUE(store.Save(CheckpointAt(10)));
  // A folder in the place of the next checkpoint makes its rename fail, also for root.
  std::filesystem::create_directory(folder_.path() / "checkpoint-000000020.ckpt");
  EXPECT_FALSE(store.Save(CheckpointAt(20)));
  std::filesystem::remove(folder_.path() / "checkpoint-000000020.ckpt");
  EXPECT_EQ((*store.LoadNewest())->checkpoint.updates, 10u);
  EXPECT_EQ(LoadPolicy(folder_.path() / "latest")->updates, 10u);
}

// The writer is killed at points that differ from round to round; what it leaves is always loadable, and
// never older than the last checkpoint it had reported.
TEST_F(CheckpointStoreTest, KilledWhileSavingLeavesTheLastReportedCheckpointOrANewerOne) {
  for (int round = 0; round < 12; ++round) {
    int pipe_ends[2];
    ASSERT_EQ(pipe(pipe_ends), 0);
    const pid_t child = fork();
    ASSERT_GE(child, 0);
    if (child == 0) {
      CheckpointStore store = Open();
      for (uint64_t updates = 1;; ++updates) {
        const uint64_t number = 1000 * static_cast<uint64_t>(round) + updates;
        if (!store.Save(CheckpointAt(number, 50000))) _exit(1);
        if (write(pipe_ends[1], &number, sizeof(number)) != sizeof(number)) _exit(1);
      }
    }
    close(pipe_ends[1]);
    uint64_t reported = 0;
    for (int i = 0; i < 2; ++i) {
      ASSERT_EQ(read(pipe_ends[0], &reported, sizeof(reported)), static_cast<ssize_t>(sizeof(reported)));
    }
    usleep(static_cast<useconds_t>(311 * round));
    kill(child, SIGKILL);
    ASSERT_EQ(waitpid(child, nullptr, 0), child);
    close(pipe_ends[0]);
    CheckpointStore store = Open();
    const auto loaded = store.LoadNewest();
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_GE((*loaded)->checkpoint.updates, reported);
    EXPECT_FALSE(std::filesystem::exists((*loaded)->path.string() + ".corrupt"));
    EXPECT_TRUE(LoadPolicy(folder_.path() / "latest"));
    EXPECT_THAT(Names(), testing::Each(testing::Not(testing::StartsWith("."))));
  }
}

}  // namespace
}  // namespace dadrl
