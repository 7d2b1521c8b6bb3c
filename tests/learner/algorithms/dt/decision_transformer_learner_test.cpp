#include "learner/algorithms/dt/decision_transformer_learner.h"

#include "common/model/policy_model.h"
#include "tests/driving_columns.h"
#include "tests/golden/golden.h"
#include "tests/learner/algorithms/state_blocks.h"

namespace dadrl {
namespace {

constexpr int kBatch = 6;
constexpr int kContext = DecisionTransformer::kContext;

Config SmallConfig(int threads = 1) {
  Config config;
  config.model.policy = "decision_transformer";
  config.observation.vehicles = 2;
  config.observation.history = 2;
  config.algorithm.batch_size = kBatch;
  config.algorithm.actor_learning_rate = 1e-3;
  config.algorithm.adam_epsilon = 1e-3;  // as in sac_golden_test.cpp, above the noise of small gradients
  config.algorithm.max_gradient_norm = 0.25;
  config.algorithm.weight_decay = 0.1;
  config.algorithm.warmup_updates = 2;
  config.learner.threads = threads;
  return config;
}

// Batch `k` of make_decision_transformer_golden.py.
TrajectoryBatch GoldenBatch(const Config& config, int k) {
  const auto salt = static_cast<uint64_t>(500 + 10 * k);
  TrajectoryBatch batch(DrivingStepSpec(config), DecisionTransformerLearner::SpecOf(config).batch);
  const auto fill = [](std::span<float> to, uint64_t from, float scale) {
    std::ranges::copy(golden::Uniform(from, to.size(), scale), to.begin());
  };
  fill(EgoOf(batch.observations), salt, 1.0f);
  fill(VehiclesOf(batch.observations), salt + 1, 1.0f);
  fill(batch.decisions[0], salt + 2, 0.99f);
  for (int b = 0; b < kBatch; ++b) batch.steps[static_cast<size_t>(b)] = 1 + (b * 7 + k) % kContext;
  return batch;
}

class DecisionTransformerGolden : public testing::TestWithParam<int> {};

TEST_P(DecisionTransformerGolden, ThreeUpdatesAgreeWithPyTorch) {
  const Config config = SmallConfig(GetParam());
  DecisionTransformerLearner learner(config);
  const nn::ParamLayout& layout = learner.network().layout;
  golden::FillParameters(layout, 3, FloatsOf(learner, "policy"));
  const std::vector<float> losses = golden::Floats("decision_transformer/losses");
  for (int k = 0; k < 3; ++k) {
    const Status updated = learner.Update(GoldenBatch(config, k));
    ASSERT_TRUE(updated) << updated.error().message;
    for (size_t i = 0; i < 2; ++i) {
      const double expected = losses[static_cast<size_t>(k) * 2 + i];
      EXPECT_NEAR(learner.scalars()[i], expected, golden::kTolerance * std::max(1.0, expected)) << k;
    }
  }
  golden::ExpectEveryNthAgrees(layout, FloatsOf(learner, "policy"),
                               golden::Floats("decision_transformer/policy"), 31);
}

INSTANTIATE_TEST_SUITE_P(Threads, DecisionTransformerGolden, testing::Values(1, 2));

TEST(DecisionTransformerLearnerTest, LearnsWhatItIsShownAndActsAsItLearnt) {
  Config config = SmallConfig();
  config.algorithm.warmup_updates = 0;
  config.algorithm.weight_decay = 0.0;
  config.algorithm.max_gradient_norm = 0.0;
  DecisionTransformerLearner learner(config);
  TrajectoryBatch batch = GoldenBatch(config, 0);
  std::ranges::fill(batch.steps, kContext);
  ASSERT_TRUE(learner.Update(batch));
  const double first = learner.scalars()[0];
  for (int i = 0; i < 60; ++i) ASSERT_TRUE(learner.Update(batch));
  EXPECT_LT(learner.scalars()[0], 0.2 * first);

  // One episode of the batch again, decision by decision: the policy says what the batch's pass said, as long
  // as it did before what was done in the batch. It acts by itself, so only its first decision is compared.
  const StepSpec spec = DrivingStepSpec(config);
  const auto policy = MakePolicyModel(spec, config.model).value();
  ASSERT_TRUE(policy->Load(learner.published_policy().parameters));
  policy->BeginEpisode();
  Observation observation(spec);
  const ColumnRows row(batch.observations, 0, 1);
  std::ranges::copy(row.floats(0), observation.floats(0).begin());
  std::ranges::copy(row.floats(1), observation.floats(1).begin());
  const Action action = policy->Act(observation, nullptr);
  for (size_t d = 0; d < 2; ++d) EXPECT_NEAR(action[d], batch.decisions[0][d], 0.4);
}

TEST(DecisionTransformerLearnerTest, WhatIsBehindAStretchDoesNotMatter) {
  const Config config = SmallConfig();
  TrajectoryBatch batch = GoldenBatch(config, 1);
  DecisionTransformerLearner a(config);
  DecisionTransformerLearner b(config);
  ASSERT_TRUE(a.Update(batch));
  for (int t = 0; t < kContext; ++t) {
    for (size_t s = 0; s < kBatch; ++s) {
      if (t < batch.steps[s]) continue;
      for (size_t d = 0; d < 2; ++d) batch.decisions[0][(static_cast<size_t>(t) * kBatch + s) * 2 + d] = 9.0f;
    }
  }
  ASSERT_TRUE(b.Update(batch));
  EXPECT_TRUE(std::ranges::equal(FloatsOf(a, "policy"), FloatsOf(b, "policy")));
}

TEST(DecisionTransformerLearnerTest, ABatchThatIsNotFiniteIsAnErrorAndStepsNothing) {
  const Config config = SmallConfig();
  DecisionTransformerLearner learner(config);
  const std::vector<float> before(FloatsOf(learner, "policy.adam_first").begin(),
                                  FloatsOf(learner, "policy.adam_first").end());
  TrajectoryBatch batch = GoldenBatch(config, 1);
  batch.decisions[0][0] = NAN;
  const Status status = learner.Update(batch);
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("is not finite in update 1"), std::string::npos);
  EXPECT_TRUE(std::ranges::equal(FloatsOf(learner, "policy.adam_first"), before));
}

}  // namespace
}  // namespace dadrl
