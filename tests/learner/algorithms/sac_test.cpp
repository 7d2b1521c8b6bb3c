// What a training process relies on: reproducible, resumable, never silently broken.
#include "learner/algorithms/sac.h"

#include <cmath>

#include "common/model/policy_model.h"
#include "tests/learner/algorithms/sac_fixture.h"

namespace dadrl {
namespace {

Config SmallConfig(EncoderSharing encoders = EncoderSharing::kSeparate, int threads = 1) {
  Config config;
  config.model.encoders = encoders;
  config.model.hidden = 48;
  config.algorithm.batch_size = 48;
  config.learner.threads = threads;
  return config;
}

const DrivingShape kSpec;

void Train(Sac& algorithm, int first, int count) {
  for (int i = first; i < first + count; ++i) {
    const auto stats = algorithm.Update(AnyBatch(kSpec, 48, 1000 * static_cast<uint64_t>(i)));
    ASSERT_TRUE(stats) << stats.error().message;
  }
}

class SacOnEverySharing : public testing::TestWithParam<EncoderSharing> {};

TEST_P(SacOnEverySharing, SameSeedGivesTheSameBitsForAThreadCount) {
  for (const int threads : {1, 2, 3}) {
    Sac first(SmallConfig(GetParam(), threads));
    Sac second(SmallConfig(GetParam(), threads));
    Train(first, 0, 4);
    Train(second, 0, 4);
    EXPECT_EQ(Snapshot(first), Snapshot(second)) << threads << " threads";
  }
}

TEST_P(SacOnEverySharing, AnotherSeedGivesAnotherTraining) {
  Config config = SmallConfig(GetParam());
  Sac first(config);
  config.seed = 2;
  Sac second(config);
  EXPECT_NE(Snapshot(first), Snapshot(second));
}

TEST_P(SacOnEverySharing, ThreadCountsDifferOnlyInRounding) {
  Sac one(SmallConfig(GetParam(), 1));
  Sac three(SmallConfig(GetParam(), 3));
  const TransitionBatch batch = AnyBatch(kSpec, 48, 7);
  ASSERT_TRUE(one.Update(batch));
  ASSERT_TRUE(three.Update(batch));
  EXPECT_NEAR(ScalarOf(one, "critic_loss"), ScalarOf(three, "critic_loss"), 1e-6);
  golden::ExpectAgrees(FloatsOf(one, "critic.adam_first"), FloatsOf(three, "critic.adam_first"),
                       "critic gradient");
  golden::ExpectAgrees(FloatsOf(one, "policy.adam_first"), FloatsOf(three, "policy.adam_first"),
                       "policy gradient");
}

TEST_P(SacOnEverySharing, RestoredStateGoesOnExactly) {
  Sac original(SmallConfig(GetParam()));
  Train(original, 0, 3);
  const std::vector<std::byte> saved = Snapshot(original);
  Train(original, 3, 3);
  Config config = SmallConfig(GetParam());
  config.seed = 99;  // everything must come from the state
  Sac resumed(config);
  Restore(resumed, saved);
  Train(resumed, 3, 3);
  EXPECT_EQ(Snapshot(resumed), Snapshot(original));
  EXPECT_TRUE(
      std::ranges::equal(resumed.published_policy().parameters, original.published_policy().parameters));
}

TEST_P(SacOnEverySharing, ABatchThatIsNoMultipleOfSixteenCountsOnlyItsOwnSamples) {
  // Seventeen samples, then the same with rubbish left in the padding by a larger batch before it.
  Config config = SmallConfig(GetParam());
  Sac fresh(config);
  Sac used(config);
  const std::vector<std::byte> start = Snapshot(fresh);
  ASSERT_TRUE(used.Update(AnyBatch(kSpec, 48, 500)));
  Restore(used, start);
  const TransitionBatch batch = AnyBatch(kSpec, 17, 600);
  ASSERT_TRUE(fresh.Update(batch));
  ASSERT_TRUE(used.Update(batch));
  EXPECT_EQ(Snapshot(fresh), Snapshot(used));
  EXPECT_EQ(fresh.priorities().size(), 17u);
}

TEST_P(SacOnEverySharing, PublishesAPolicyThatActorsAccept) {
  for (const PublishedPolicy publish : {PublishedPolicy::kAveraged, PublishedPolicy::kCurrent}) {
    Config config = SmallConfig(GetParam());
    config.learner.publish = publish;
    Sac sac(config);
    Train(sac, 0, 2);
    const auto policy = MakePolicyModel(kSpec, config.model).value();
    EXPECT_EQ(policy->layout().hash(), sac.published_policy().layout_hash);
    EXPECT_TRUE(policy->Load(sac.published_policy().parameters));
    const std::string name = publish == PublishedPolicy::kAveraged ? "policy_average" : "policy";
    EXPECT_TRUE(std::ranges::equal(sac.published_policy().parameters, FloatsOf(sac, name)));
    EXPECT_FALSE(std::ranges::equal(FloatsOf(sac, "policy"), FloatsOf(sac, "policy_average")));
  }
}

TEST_P(SacOnEverySharing, FitsAFixedBatch) {
  Config config = SmallConfig(GetParam());
  config.algorithm.tau = 0.0;  // a fixed target makes this a regression
  Sac sac(config);
  TransitionBatch batch = AnyBatch(kSpec, 48, 3);
  std::ranges::fill(batch.discount, 0.0f);
  ASSERT_TRUE(sac.Update(batch));
  const double before = ScalarOf(sac, "critic_loss");
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(sac.Update(batch));
  ASSERT_TRUE(sac.Update(batch));
  EXPECT_LT(ScalarOf(sac, "critic_loss"), 0.1 * before);
}

TEST_P(SacOnEverySharing, NamesTheBadTensorOfABatchAndChangesNothing) {
  Sac sac(SmallConfig(GetParam()));
  const std::vector<std::byte> before = Snapshot(sac);
  const std::pair<const char*, std::vector<float> TransitionBatch::*> tensors[] = {
      {"action", &TransitionBatch::action},
      {"reward", &TransitionBatch::reward},
      {"discount", &TransitionBatch::discount},
      {"weight", &TransitionBatch::weight}};
  for (const auto& [name, member] : tensors) {
    for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
      TransitionBatch batch = AnyBatch(kSpec, 48, 1);
      (batch.*member).back() = bad;
      const auto stats = sac.Update(batch);
      ASSERT_FALSE(stats) << name;
      EXPECT_EQ(stats.error().code, ErrorCode::kInternal);
      EXPECT_NE(stats.error().message.find(name), std::string::npos) << stats.error().message;
    }
  }
  TransitionBatch batch = AnyBatch(kSpec, 48, 1);
  EgoOf(batch.next_observation)[5] = std::nanf("");
  const auto stats = sac.Update(batch);
  ASSERT_FALSE(stats);
  EXPECT_NE(stats.error().message.find("next_observation.ego"), std::string::npos) << stats.error().message;
  EXPECT_EQ(Snapshot(sac), before);
}

TEST_P(SacOnEverySharing, LossBeyondFloatStopsBeforeTheStep) {
  Sac sac(SmallConfig(GetParam()));
  const std::span<float> critic = FloatsOf(sac, "critic");
  critic[sac.critic().layout.Find("critic1.output.weight")->offset] = 3e38f;
  critic[sac.critic().layout.Find("critic1.output.weight")->offset + 1] = 3e38f;
  for (size_t i = 0; i < 48; ++i)
    critic[sac.critic().layout.Find("critic1.output.weight")->offset + i] = 3e38f;
  const std::vector<float> before(critic.begin(), critic.end());
  const auto stats = sac.Update(AnyBatch(kSpec, 48, 1));
  ASSERT_FALSE(stats);
  EXPECT_NE(stats.error().message.find("critic loss"), std::string::npos) << stats.error().message;
  EXPECT_TRUE(std::ranges::equal(critic, before));
}

TEST_P(SacOnEverySharing, NamesTheParameterThatOverflows) {
  Sac sac(SmallConfig(GetParam()));
  const std::string tensor = "critic2.hidden1.bias";
  FloatsOf(sac, "critic.adam_first")[sac.critic().layout.Find(tensor)->offset] = HUGE_VALF;
  const auto stats = sac.Update(AnyBatch(kSpec, 48, 1));
  ASSERT_FALSE(stats);
  EXPECT_EQ(stats.error().code, ErrorCode::kInternal);
  EXPECT_NE(stats.error().message.find(tensor), std::string::npos) << stats.error().message;
}

TEST_P(SacOnEverySharing, RefusesBatchesOfAnotherShape) {
  Sac sac(SmallConfig(GetParam()));
  EXPECT_EQ(sac.Update(AnyBatch(kSpec, 64, 1)).error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(sac.Update(TransitionBatch(kSpec, 0)).error().code, ErrorCode::kInvalidArgument);
  DrivingShape other;
  other.vehicles = 5;
  EXPECT_EQ(sac.Update(AnyBatch(other, 48, 1)).error().code, ErrorCode::kInvalidArgument);
}

std::string SharingName(const testing::TestParamInfo<EncoderSharing>& info) {
  return info.param == EncoderSharing::kShared ? "Shared" : "Separate";
}

INSTANTIATE_TEST_SUITE_P(Encoders, SacOnEverySharing,
                         testing::Values(EncoderSharing::kSeparate, EncoderSharing::kShared), SharingName);

// Two views in place of one: as reproducible, resumable and free of padding.
TEST(SacTest, WithShiftedViewsItIsAsReproducibleAndResumable) {
  for (const EncoderSharing sharing : {EncoderSharing::kSeparate, EncoderSharing::kShared}) {
    Config config = SmallConfig(sharing, 2);
    config.algorithm.shift_pixels = 2;
    Sac first(config);
    Sac second(config);
    Train(first, 0, 2);
    Train(second, 0, 2);
    EXPECT_EQ(Snapshot(first), Snapshot(second));
    config.seed = 99;
    Sac resumed(config);
    Restore(resumed, Snapshot(first));
    Train(first, 2, 2);
    Train(resumed, 2, 2);
    EXPECT_EQ(Snapshot(first), Snapshot(resumed));
    const TransitionBatch batch = AnyBatch(kSpec, 17, 600);
    ASSERT_TRUE(first.Update(batch));
    ASSERT_TRUE(second.Update(AnyBatch(kSpec, 48, 500)));
    Restore(second, Snapshot(resumed));
    ASSERT_TRUE(second.Update(batch));
    EXPECT_EQ(Snapshot(first), Snapshot(second));
    EXPECT_EQ(first.priorities().size(), 17u);
  }
}

TEST(SacTest, MoreThreadsThanBlocksWork) {
  Config config = SmallConfig(EncoderSharing::kSeparate, 4);
  config.algorithm.batch_size = 32;
  Sac sac(config);
  EXPECT_TRUE(sac.Update(AnyBatch(kSpec, 32, 1)));
}

TEST(SacTest, TemperatureFollowsTheTargetEntropy) {
  for (const double target_entropy : {-50.0, 50.0}) {
    Config config = SmallConfig();
    config.model.context = false;
    config.algorithm.target_entropy = target_entropy;
    Sac sac(config);
    double temperature = config.algorithm.initial_temperature;
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(sac.Update(AnyBatch(kSpec, 48, 1)));
      const double now = ScalarOf(sac, "temperature");
      EXPECT_EQ(now > temperature, target_entropy > 0.0);
      temperature = now;
    }
  }
}

}  // namespace
}  // namespace dadrl
