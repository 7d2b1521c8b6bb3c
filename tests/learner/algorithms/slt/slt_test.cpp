#include "learner/algorithms/slt/slt.h"

#include "learner/algorithms/registry.h"
#include "tests/golden/scene_ways.h"
#include "tests/learner/algorithms/sac_fixture.h"

namespace dadrl {
namespace {

constexpr int kBatch = 18;

Config SmallConfig(int threads = 1) {
  Config config;
  config.algorithm.name = "slt";
  config.observation.polylines = config.model.scene = true;
  config.model.stae = config.model.context = false;
  config.model.encoders = EncoderSharing::kShared;
  config.model.hidden = 32;
  config.algorithm.batch_size = kBatch;
  config.algorithm.n_step = 1;
  config.algorithm.gamma = 0.99;
  config.algorithm.initial_temperature = 0.2;
  config.algorithm.adam_epsilon = 1e-5;
  config.algorithm.actor_learning_rate = config.algorithm.critic_learning_rate =
      config.algorithm.temperature_learning_rate = 3e-4;
  config.learner.threads = threads;
  return config;
}

// Step `k` of the golden inputs, and the observation behind it.
TrajectoryBatch GoldenBatch(const Config& config, int k) {
  TrajectoryBatch batch(DrivingStepSpec(config), Slt::SpecOf(config).batch);
  const DrivingShape shape = DrivingShape::From(config.observation);
  for (int t = 0; t < 2; ++t) {
    const std::string suffix = std::to_string(k + t);
    const MutableColumnRows rows(batch.observations, t * kBatch, kBatch);
    std::ranges::copy(golden::Floats("inputs/vehicles" + suffix), rows.floats(shape.vehicles_column).begin());
    std::ranges::copy(golden::Floats("inputs/ego" + suffix), rows.floats(shape.ego_column).begin());
    Columns ways(shape, kBatch);
    FillWays(shape, k + t, ways);
    std::ranges::copy(ways.floats(shape.polylines_column), rows.floats(shape.polylines_column).begin());
  }
  const std::string suffix = std::to_string(k);
  batch.decisions[0] = golden::Floats("inputs/action" + suffix);
  batch.rewards = golden::Floats("inputs/reward" + suffix);
  batch.weights = golden::Floats("inputs/weight" + suffix);
  const std::vector<float> discount = golden::Floats("inputs/discount" + suffix);
  for (size_t b = 0; b < kBatch; ++b) {
    batch.steps[b] = 1;
    batch.terminated[b] = discount[b] == 0.0f ? 1 : 0;
  }
  return batch;
}

class SltGolden : public testing::TestWithParam<int> {};

TEST_P(SltGolden, ThreeUpdatesAgreeWithPyTorch) {
  const Config config = SmallConfig(GetParam());
  auto noise = std::make_unique<RecordedNoise>();
  for (int k = 0; k < 3; ++k) {
    noise->Push(golden::Floats("inputs/next_noise" + std::to_string(k)));
    noise->Push(golden::Floats("inputs/now_noise" + std::to_string(k)));
  }
  Slt slt(config, std::move(noise));
  const std::span<float> policy = FloatsOf(slt, "policy");
  const std::span<float> critic = FloatsOf(slt, "critic");
  golden::FillParameters(slt.sac().policy().layout, 1, policy);
  golden::FillParameters(slt.sac().critic().layout, 2, critic);
  golden::FillParameters(slt.prediction_layout(), 4, FloatsOf(slt, "latent"));
  std::ranges::copy(critic.first(slt.sac().policy().encoder_range.count), policy.begin());
  std::ranges::copy(critic, FloatsOf(slt, "target").begin());
  const std::vector<float> losses = golden::Floats("slt/losses");
  const std::vector<float> latent = golden::Floats("slt/latent_losses");
  for (int k = 0; k < 3; ++k) {
    const Status updated = slt.Update(GoldenBatch(config, k));
    ASSERT_TRUE(updated) << updated.error().message;
    const auto index = static_cast<size_t>(k);
    EXPECT_NEAR(ScalarOf(slt, "latent_loss"), latent[index], golden::kTolerance) << k;
    const double critic_loss = losses[index * 7];
    EXPECT_NEAR(ScalarOf(slt, "critic_loss"), critic_loss, golden::kTolerance * std::max(1.0, critic_loss));
  }
  golden::ExpectEveryNthAgrees(slt.sac().critic().layout, critic, golden::Floats("slt/critic"), 31);
  golden::ExpectEveryNthAgrees(slt.prediction_layout(), FloatsOf(slt, "latent"), golden::Floats("slt/latent"),
                               31);
}

INSTANTIATE_TEST_SUITE_P(Threads, SltGolden, testing::Values(1, 2));

TEST(SltTest, PredictsSeveralStepsAheadAndNothingBehindATermination) {
  Config config = SmallConfig();
  config.algorithm.latent_steps = 3;
  TrajectoryBatch batch(DrivingStepSpec(config), Slt::SpecOf(config).batch);
  EXPECT_EQ(batch.shape.steps, 3);
  const DrivingShape shape = DrivingShape::From(config.observation);
  const auto fill = [](std::span<float> to, uint64_t salt) {
    std::ranges::copy(golden::Uniform(salt, to.size(), 0.9f), to.begin());
  };
  fill(batch.observations.floats(shape.vehicles_column), 1);
  fill(batch.observations.floats(shape.ego_column), 2);
  fill(batch.observations.floats(shape.polylines_column), 3);
  fill(batch.decisions[0], 4);
  std::ranges::fill(batch.steps, 2);
  std::ranges::fill(batch.terminated, uint8_t{1});
  TrajectoryBatch other = batch;
  // Behind the only step that is followed by one.
  const size_t behind = static_cast<size_t>(2 * kBatch) * static_cast<size_t>(shape.ego_floats());
  for (float& value : other.observations.floats(shape.ego_column).subspan(behind)) value = -value;
  Slt a(config);
  Slt b(config);
  ASSERT_TRUE(a.Update(batch));
  ASSERT_TRUE(b.Update(other));
  EXPECT_EQ(ScalarOf(a, "latent_loss"), ScalarOf(b, "latent_loss"));
  EXPECT_GE(ScalarOf(a, "latent_loss"), -1.0);
}

TEST(SltTest, ATrainingGoesOnFromItsStateBitForBit) {
  const Config config = SmallConfig(2);
  Slt first(config);
  ASSERT_TRUE(first.Update(GoldenBatch(config, 0)));
  Slt second(config);
  Restore(second, Snapshot(first));
  ASSERT_TRUE(first.Update(GoldenBatch(config, 1)));
  ASSERT_TRUE(second.Update(GoldenBatch(config, 1)));
  EXPECT_EQ(Snapshot(first), Snapshot(second));
}

TEST(SltTest, NeedsTheSceneEncoder) {
  Config config = SmallConfig();
  config.model.scene = false;
  config.model.stae = true;
  const auto made = MakeAlgorithm(config);
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().message,
            "algorithm.name: slt trains the scene encoder, and model.scene is false; set it to true");
}

TEST(LatentPredictionTest, ACosineHasNoGradientAlongThePrediction) {
  const std::vector<float> prediction = {1.0f, 2.0f, -1.0f};
  const std::vector<float> target = {0.5f, -1.0f, 2.0f};
  std::vector<float> gradient(3);
  const double loss = NegativeCosine(prediction, target, 1.0, gradient);
  EXPECT_NEAR(loss, 3.5 / std::sqrt(6.0 * 5.25), 1e-6);
  EXPECT_NEAR(gradient[0] + 2.0f * gradient[1] - gradient[2], 0.0, 1e-6);
  EXPECT_EQ(NegativeCosine(prediction, std::vector<float>(3), 1.0, gradient), 0.0);
}

}  // namespace
}  // namespace dadrl
