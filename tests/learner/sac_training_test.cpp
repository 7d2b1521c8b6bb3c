// The training loop with the real algorithm.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/io/read_file.h"
#include "common/model/policy_file.h"
#include "common/model/policy_model.h"
#include "common/model/value_model.h"
#include "learner/algorithms/registry.h"
#include "learner/training_log.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/learner/algorithms/sac_fixture.h"
#include "tests/learner/test_learner.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

class SacTrainingTest : public testing::TestWithParam<EncoderSharing> {
 protected:
  SacTrainingTest() {
    config_.algorithm.batch_size = 16;
    config_.model.hidden = 32;
    config_.model.encoders = GetParam();
  }
  std::unique_ptr<Algorithm> Sac(uint64_t seed = 1) {
    config_.seed = seed;
    auto algorithm = MakeAlgorithm(config_);
    EXPECT_TRUE(algorithm);
    return std::move(*algorithm);
  }

  Config config_;
  TemporaryFolder folder_;
};

TEST_P(SacTrainingTest, ResumedTrainingEqualsAnUninterruptedOneBitForBit) {
  constexpr int kUpdates = 4;
  TemporaryFolder other;
  TestLearner whole(config_, other.path(), false, 0, Sac());
  whole.Steps(2 * kUpdates);
  {
    TestLearner first(config_, folder_.path(), false, 0, Sac());
    first.Steps(kUpdates);
    ASSERT_TRUE(first.trainer->SaveNow());
  }
  // Made from another seed: everything that matters must come from the checkpoint.
  TestLearner second(config_, folder_.path(), true, kUpdates, Sac(2));
  ASSERT_TRUE(second.trainer) << second.error.message;
  ASSERT_NE(StateOf(*second.algorithm), StateOf(*whole.algorithm));
  second.Steps(kUpdates);
  EXPECT_EQ(StateOf(*second.algorithm), StateOf(*whole.algorithm));
  EXPECT_THAT(second.algorithm->published_policy().parameters,
              testing::ElementsAreArray(whole.algorithm->published_policy().parameters));
}

TEST_P(SacTrainingTest, NaNInABatchEndsTheTrainingWithItsNameAndPublishesNothing) {
  TestLearner learner(config_, folder_.path(), false, 0, Sac());
  learner.Steps(2);
  ASSERT_TRUE(learner.trainer->SaveNow());
  const auto published = learner.publisher.versions;
  learner.batches.poisoned = true;
  learner.clock.Advance(std::chrono::hours(1));
  const std::atomic<bool> stop{false};
  const auto ended = learner.trainer->Run(stop);
  ASSERT_FALSE(ended);
  EXPECT_EQ(ended.error().code, ErrorCode::kInternal);
  EXPECT_THAT(ended.error().message, HasSubstr("reward"));
  EXPECT_EQ(learner.publisher.versions, published);
  EXPECT_EQ(LoadPolicy(folder_.path() / "latest")->updates, 2u);
}

TEST_P(SacTrainingTest, SavedPolicyActsInTheNetworksOfItsOwnConfiguration) {
  TestLearner learner(config_, folder_.path(), false, 0, Sac());
  learner.Steps(2);
  ASSERT_TRUE(learner.trainer->SaveNow());
  const auto path = folder_.path() / "latest";
  const auto policy = LoadPolicy(path);
  ASSERT_TRUE(policy) << policy.error().message;
  const DrivingShape spec = DrivingShape::From(policy->config.observation);
  const auto acting = MakePolicyModel(spec, policy->config.model).value();
  ASSERT_TRUE(CheckLayout(policy->policy(), path, acting->layout().hash(), acting->layout().size()));
  ASSERT_TRUE(acting->Load(policy->policy().parameters));
  const Action action = acting->Act(Observation(spec), nullptr);
  EXPECT_LT(std::abs(action[0]), 1.0f);
  const StoredNetwork* critic = policy->Find(kCriticNetwork);
  ASSERT_NE(critic, nullptr);
  const nn::ParamLayout layout = MakeValueModel(kCriticNetwork, spec, policy->config.model).value()->layout();
  ASSERT_TRUE(CheckLayout(*critic, path, layout.hash(), layout.size()));
  EXPECT_THAT(critic->parameters, testing::ElementsAreArray(FloatsOf(*learner.algorithm, "critic")));
}

// A run is continued in the table that it began, while these stay the same.
TEST(SacTrainingLog, HasItsColumns) {
  const TemporaryFolder folder;
  const SystemClock clock;
  FaultBoard faults(clock);
  const TrainingLog log(folder.path(), 0, Sac::SpecOf({}).scalars, faults);
  EXPECT_EQ(
      ReadTextFile(folder.path() / "logs" / "training.csv", 1 << 20).value(),
      "wall_time_s,trained_s,cpu_s,updates,updates_per_s,critic_loss,actor_loss,temperature_loss,temperature,"
      "entropy,"
      "mean_q,mean_target,weights_version,staleness_versions_mean,staleness_versions_max,staleness_s_mean,"
      "staleness_s_max,batch_mb_per_s,work_fraction,replay_frames\n");
}

INSTANTIATE_TEST_SUITE_P(Encoders, SacTrainingTest,
                         testing::Values(EncoderSharing::kSeparate, EncoderSharing::kShared));

}  // namespace
}  // namespace dadrl
