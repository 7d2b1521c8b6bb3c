// What a training process relies on: reproducible, resumable, never silently broken.
#include "learner/algorithms/ppo/ppo.h"

#include <gmock/gmock.h>

#include <cmath>

#include "common/model/policy_model.h"
#include "tests/learner/algorithms/ppo/rollout.h"
#include "tests/learner/algorithms/sac_fixture.h"

namespace dadrl {
namespace {

using testing::HasSubstr;

Config ConfigOf(EncoderSharing encoders = EncoderSharing::kSeparate, int threads = 1) {
  Config config = SmallPpo(36, 4);
  config.model.encoders = encoders;
  config.algorithm.epochs = 2;
  config.learner.threads = threads;
  return config;
}

TrajectoryBatch RolloutOf(const Config& config, uint64_t salt) {
  return AnyRollout(config, Ppo::SpecOf(config).batch, 1000 * salt);
}

void Train(Ppo& ppo, const Config& config, uint64_t first, uint64_t count) {
  for (uint64_t i = first; i < first + count; ++i) {
    const Status updated = ppo.Update(RolloutOf(config, i));
    ASSERT_TRUE(updated) << updated.error().message;
  }
}

class PpoOnEverySharing : public testing::TestWithParam<EncoderSharing> {};

TEST_P(PpoOnEverySharing, SameSeedGivesTheSameBitsForAThreadCount) {
  for (const int threads : {1, 2, 3}) {
    const Config config = ConfigOf(GetParam(), threads);
    Ppo first(config);
    Ppo second(config);
    Train(first, config, 0, 2);
    Train(second, config, 0, 2);
    EXPECT_EQ(Snapshot(first), Snapshot(second)) << threads << " threads";
  }
}

TEST_P(PpoOnEverySharing, RestoredStateGoesOnExactly) {
  Config config = ConfigOf(GetParam());
  Ppo original(config);
  Train(original, config, 0, 2);
  const std::vector<std::byte> saved = Snapshot(original);
  Train(original, config, 2, 2);
  config.seed = 99;  // everything must come from the state
  Ppo resumed(config);
  Restore(resumed, saved);
  Train(resumed, config, 2, 2);
  EXPECT_EQ(Snapshot(resumed), Snapshot(original));
}

// What lies behind the end of a trajectory is none of its business.
TEST_P(PpoOnEverySharing, LearnsNothingFromBehindATrajectorysEnd) {
  const Config config = ConfigOf(GetParam());
  Ppo clean(config);
  Ppo dirty(config);
  TrajectoryBatch batch = RolloutOf(config, 1);
  ASSERT_TRUE(clean.Update(batch));
  const auto count = static_cast<size_t>(batch.shape.count);
  for (size_t t = 2; t < 4; ++t) {  // trajectory 1 terminated after two steps
    batch.rewards[t * count + 1] = 50.0f;
    batch.decisions[0][(t * count + 1) * 2] = -0.5f;
    EgoOf(batch.observations)[(t * count + 1) * 100] = 3.0f;
  }
  ASSERT_TRUE(dirty.Update(batch));
  EXPECT_EQ(Snapshot(clean), Snapshot(dirty));
}

TEST_P(PpoOnEverySharing, PublishesAPolicyThatActorsAccept) {
  const Config config = ConfigOf(GetParam());
  Ppo ppo(config);
  Train(ppo, config, 0, 1);
  const auto policy = MakePolicyModel(DrivingStepSpec(config), config.model).value();
  EXPECT_EQ(policy->layout().hash(), ppo.published_policy().layout_hash);
  EXPECT_TRUE(policy->Load(ppo.published_policy().parameters));
}

// One situation, one decision an episode: what is rewarded becomes likelier.
TEST_P(PpoOnEverySharing, DoesMoreOfWhatIsRewarded) {
  Config config = SmallPpo(64, 1);
  config.model.encoders = GetParam();
  config.algorithm.actor_learning_rate = 1e-3;
  config.algorithm.epochs = 4;
  Ppo ppo(config);
  const auto actor = MakePolicyModel(DrivingStepSpec(config), config.model).value();
  Random random(1);
  double first = 0.0;
  double last = 0.0;
  for (int update = 0; update < 30; ++update) {
    TrajectoryBatch batch(DrivingStepSpec(config), ppo.spec().batch);
    ASSERT_TRUE(actor->Load(ppo.published_policy().parameters));
    const Observation observation{DrivingStepSpec(config)};
    last = 0.0;
    for (size_t i = 0; i < 64; ++i) {
      const Action action = actor->Act(observation, &random);
      std::ranges::copy(action, batch.decisions[0].begin() + static_cast<ptrdiff_t>(2 * i));
      batch.decisions[1][i] = *actor->last().log_probability;
      batch.rewards[i] = -std::abs(action[0] - 0.6f);
      last += static_cast<double>(batch.rewards[i]) / 64;
    }
    std::ranges::fill(batch.steps, 1);
    std::ranges::fill(batch.terminated, uint8_t{1});
    if (update == 0) first = last;
    ASSERT_TRUE(ppo.Update(batch));
    if (update == 0) {
      EXPECT_LT(ScalarOf(ppo, "divergence"), 0.05);
    }
  }
  EXPECT_GT(last, 0.5 * first);
}

TEST_P(PpoOnEverySharing, NamesTheBadTensorOfABatchAndChangesNothing) {
  const Config config = ConfigOf(GetParam());
  Ppo ppo(config);
  const std::vector<std::byte> before = Snapshot(ppo);
  for (const char* name : {"action", "log_probability", "reward", "observation.ego"}) {
    TrajectoryBatch batch = RolloutOf(config, 1);
    const std::string tensor = name;
    float& value = tensor == "reward"            ? batch.rewards[0]
                   : tensor == "action"          ? batch.decisions[0][0]
                   : tensor == "log_probability" ? batch.decisions[1][0]
                                                 : EgoOf(batch.observations)[0];
    value = std::nanf("");
    const Status updated = ppo.Update(batch);
    ASSERT_FALSE(updated) << name;
    EXPECT_THAT(updated.error().message, HasSubstr(name));
  }
  EXPECT_EQ(Snapshot(ppo), before);
}

TEST_P(PpoOnEverySharing, RefusesBatchesOfAnotherShape) {
  const Config config = ConfigOf(GetParam());
  Ppo ppo(config);
  TrajectoryShape shape = ppo.spec().batch;
  shape.steps = 5;
  EXPECT_EQ(ppo.Update(AnyRollout(config, shape, 1)).error().code, ErrorCode::kInvalidArgument);
}

INSTANTIATE_TEST_SUITE_P(Encoders, PpoOnEverySharing,
                         testing::Values(EncoderSharing::kSeparate, EncoderSharing::kShared));

}  // namespace
}  // namespace dadrl
