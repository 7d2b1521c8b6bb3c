// The scene encoder against PyTorch in float64, in a batch and acting.
#include "common/model/scene_encoder.h"

#include "common/model/squashed_gaussian_policy.h"
#include "tests/common/model/model_fixture.h"

namespace dadrl {
namespace {

const ModelConfig& SceneAlone() {
  static const ModelConfig model = [] {
    ModelConfig scene;
    scene.scene = true;
    scene.stae = scene.context = false;
    return scene;
  }();
  return model;
}

constexpr DrivingShape kShape{.polylines = true};

using SceneEncoderTest = ModelOnEveryIsa;

TEST_P(SceneEncoderTest, FeaturesAndGradientsAgreeWithPyTorch) {
  nn::ParamLayout layout;
  const Encoder encoder = Encoder::Add(layout, "encoder", kShape, SceneAlone());
  nn::FloatBuffer parameters(layout.size());
  golden::FillParameters(layout, 47, parameters.span());
  EncoderRun run(encoder, GoldenScenes(0), true);
  const std::vector<float> features = run.Forward(parameters.data());
  golden::ExpectAgrees(features, golden::Floats("scene/output"), "features");
  nn::FloatBuffer gradients(layout.size());
  run.Backward(parameters.data(), golden::Uniform(48, features.size()), gradients.data());
  golden::ExpectEveryNthAgrees(layout, gradients.span(), golden::Floats("scene/gradient"), 31);
}

TEST_P(SceneEncoderTest, ActingAgreesWithTheBatch) {
  const PolicyNetwork network(kShape, SceneAlone());
  std::vector<float> parameters(network.layout.size());
  network.layout.Initialize(4, parameters);
  const Columns batch = GoldenScenes(1);
  EncoderRun run(network.encoder, batch, false);
  const std::vector<float> expected = BatchedOutput(network, parameters, run, batch.rows());
  const auto policy = MakeSquashedGaussianPolicy(kShape, SceneAlone()).value();
  ASSERT_TRUE(policy->Load(parameters));
  for (int i = 0; i < batch.rows(); ++i) {
    policy->Act(OneOf(batch, kShape, i), nullptr);
    for (size_t d = 0; d < 2; ++d) {
      EXPECT_NEAR(policy->last().Find("mean")[d], expected[static_cast<size_t>(i) * 4 + d], 1e-5) << i;
    }
    float total = 0.0f;
    for (size_t v = 0; v < 6; ++v) {
      const float weight = policy->last().attention[v];
      const bool gone = VehiclesOf(batch)[((static_cast<size_t>(i) * 6 + v) * 5 + 4) * 7] > 0.5f;
      EXPECT_TRUE(gone ? weight == 0.0f : weight > 0.0f) << i << ", " << v;
      total += weight;
    }
    EXPECT_LT(total, 1.0f) << "the rest is the ego's own";
  }
}

TEST_P(SceneEncoderTest, WhatIsAbsentDoesNotMatter) {
  nn::ParamLayout layout;
  const Encoder encoder = Encoder::Add(layout, "encoder", kShape, SceneAlone());
  nn::FloatBuffer parameters(layout.size());
  layout.Initialize(5, parameters.span());
  Columns batch = GoldenScenes(2);
  const std::vector<float> before = EncoderRun(encoder, batch, false).Forward(parameters.data());
  const std::span<float> ways = batch.floats(kShape.polylines_column);
  for (size_t at = 0; at < ways.size(); at += 5) {
    if (ways[at] > 0.5f) std::ranges::fill(ways.subspan(at + 1, 4), 0.7f);
  }
  const std::vector<float> after = EncoderRun(encoder, batch, false).Forward(parameters.data());
  for (size_t i = 0; i < before.size(); ++i) ASSERT_NEAR(before[i], after[i], 1e-6) << i;
}

INSTANTIATE_TEST_SUITE_P(Isa, SceneEncoderTest, nn::AllIsas(), nn::IsaTestName);

}  // namespace
}  // namespace dadrl
