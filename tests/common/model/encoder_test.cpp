// The encoder and the heads against PyTorch in float64, and against finite differences.
#include "common/model/encoder.h"

#include <cmath>

#include "common/model/mlp.h"
#include "tests/common/model/model_fixture.h"
#include "tests/driving_columns.h"

namespace dadrl {
namespace {

using golden::ExpectAgrees;
using golden::ExpectTensorsAgree;
using golden::Floats;
using golden::Uniform;

using EncoderTest = ModelOnEveryIsa;

TEST_P(EncoderTest, FeaturesAndGradientsAgreeWithPyTorch) {
  nn::ParamLayout layout;
  const Encoder encoder = Encoder::Add(layout, "encoder", {}, {});
  nn::FloatBuffer parameters(layout.size());
  golden::FillParameters(layout, 47, parameters.span());
  EncoderRun run(encoder, GoldenObservations(0), true);
  const std::vector<float> features = run.Forward(parameters.data());
  ExpectAgrees(features, Floats("encoder/output"), "features");
  nn::FloatBuffer gradients(layout.size());
  run.Backward(parameters.data(), Uniform(48, features.size()), gradients.data());
  ExpectTensorsAgree(layout, gradients.span(), Floats("encoder/gradient"), "gradient of");
}

TEST_P(EncoderTest, ForgettingActivationsChangesNoFeature) {
  nn::ParamLayout layout;
  const Encoder encoder = Encoder::Add(layout, "encoder", {}, {});
  nn::FloatBuffer parameters(layout.size());
  layout.Initialize(3, parameters.span());
  const Columns batch = GoldenObservations(1);
  EXPECT_EQ(EncoderRun(encoder, batch, true).Forward(parameters.data()),
            EncoderRun(encoder, batch, false).Forward(parameters.data()));
}

TEST_P(EncoderTest, AblationPassesTheRawTensorsThrough) {
  ModelConfig model;
  model.stae = false;
  nn::ParamLayout layout;
  const Encoder encoder = Encoder::Add(layout, "encoder", {}, model);
  EXPECT_EQ(encoder.features(), 100 + 210 + 128);
  nn::FloatBuffer parameters(layout.size());
  const Columns batch = GoldenObservations(2);
  const std::vector<float> features = EncoderRun(encoder, batch, false).Forward(parameters.data());
  for (size_t i = 0; i < kGoldenBatch; ++i) {
    for (size_t j = 0; j < 100; ++j) ASSERT_EQ(features[i * 438 + j], EgoOf(batch)[i * 100 + j]);
    for (size_t j = 0; j < 210; ++j) ASSERT_EQ(features[i * 438 + 100 + j], VehiclesOf(batch)[i * 210 + j]);
  }
}

// The gradient of sum(features^2) along a random direction of the parameters, by central differences.
TEST_P(EncoderTest, DirectionalDerivativeAgreesWithFiniteDifferences) {
  ModelConfig model;
  model.context = false;
  const DrivingShape spec{.vehicles = 3, .history = 2};
  nn::ParamLayout layout;
  const Encoder encoder = Encoder::Add(layout, "encoder", spec, model);
  nn::FloatBuffer parameters(layout.size());
  layout.Initialize(5, parameters.span());
  Columns batch(spec, 7);
  std::ranges::copy(Uniform(1, VehiclesOf(batch).size()), VehiclesOf(batch).begin());
  std::ranges::copy(Uniform(2, EgoOf(batch).size()), EgoOf(batch).begin());
  EncoderRun run(encoder, batch, true);
  const auto loss = [&](const nn::FloatBuffer& at) {
    double sum = 0.0;
    for (const float f : run.Forward(at.data())) sum += static_cast<double>(f) * static_cast<double>(f);
    return sum;
  };
  const std::vector<float> direction = Uniform(9, layout.size());
  std::vector<float> feature_gradient = run.Forward(parameters.data());
  for (float& f : feature_gradient) f *= 2.0f;
  nn::FloatBuffer gradients(layout.size());
  run.Backward(parameters.data(), feature_gradient, gradients.data());
  constexpr float kStep = 1e-3f;
  nn::FloatBuffer up(layout.size()), down(layout.size());
  double expected = 0.0;
  for (size_t i = 0; i < layout.size(); ++i) {
    up.data()[i] = parameters.data()[i] + kStep * direction[i];
    down.data()[i] = parameters.data()[i] - kStep * direction[i];
    expected += static_cast<double>(gradients.data()[i]) * static_cast<double>(direction[i]);
  }
  const double measured = (loss(up) - loss(down)) / (2.0 * static_cast<double>(kStep));
  EXPECT_NEAR(measured, expected, 2e-3 * std::abs(expected));
}

TEST_P(EncoderTest, MlpAgreesWithPyTorchWithAndWithoutLayerNorm) {
  for (const bool layer_norm : {false, true}) {
    const std::string folder = layer_norm ? "mlp_layer_norm" : "mlp";
    const nn::LaneKernels& k = kernels();
    nn::ParamLayout layout;
    const Mlp mlp = Mlp::Add(layout, "m", 30, 40, 3, layer_norm);
    nn::FloatBuffer parameters(layout.size());
    golden::FillParameters(layout, 44, parameters.span());
    nn::FloatBuffer input = nn::ToLaneBuffer(Uniform(45, kGoldenBatch * 30), kGoldenBatch, 30);
    nn::FloatBuffer gradient = nn::ToLaneBuffer(Uniform(46, kGoldenBatch * 3), kGoldenBatch, 3);
    nn::FloatBuffer output = nn::LaneBuffer(kGoldenBatch, 3);
    nn::FloatBuffer input_gradient = nn::LaneBuffer(kGoldenBatch, 30);
    nn::FloatBuffer part = nn::LaneBuffer(kGoldenBatch, 2);
    nn::FloatBuffer gradients(layout.size());
    const int blocks = nn::BlocksOf(kGoldenBatch);
    nn::Arena measure;
    MlpActivations(measure, mlp, blocks);
    MlpScratch(measure, mlp, blocks);
    nn::Arena arena(measure.used());
    const MlpActivations activations(arena, mlp, blocks);
    const MlpScratch scratch(arena, mlp, blocks);
    const nn::LaneSpan in = nn::Contiguous(input.data(), 30);
    const nn::LaneSpan out = nn::Contiguous(output.data(), 3);
    const nn::LaneSpan d_out = nn::Contiguous(gradient.data(), 3);
    const nn::LaneSpan d_in = nn::Contiguous(input_gradient.data(), 30);
    const nn::LaneSpan d_part = nn::Contiguous(part.data(), 2);

    MlpForward(k, mlp, parameters.data(), in, blocks, activations, out);
    ExpectAgrees(nn::ToRowVector(out, kGoldenBatch, 3), Floats(folder + "/output"), folder + " output");
    MlpBackward(k, mlp, parameters.data(), in, blocks, activations, d_out,
                {.parameters = gradients.data(), .input = d_in, .input_count = 30}, scratch);
    const std::vector<float> golden_input = Floats(folder + "/input_gradient");
    ExpectAgrees(nn::ToRowVector(d_in, kGoldenBatch, 30), golden_input, folder + " input");
    ExpectTensorsAgree(layout, gradients.span(), Floats(folder + "/gradient"), folder + " gradient of");

    // The gradient of some inputs alone, as the actor loss needs it of the action.
    MlpBackward(k, mlp, parameters.data(), in, blocks, activations, d_out,
                {.input = d_part, .first_input = 28, .input_count = 2}, scratch);
    const std::vector<float> ours = nn::ToRowVector(d_part, kGoldenBatch, 2);
    for (size_t i = 0; i < kGoldenBatch; ++i) {
      for (size_t j = 0; j < 2; ++j) EXPECT_NEAR(ours[i * 2 + j], golden_input[i * 30 + 28 + j], 1e-5);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, EncoderTest, nn::AllIsas(), nn::IsaTestName);

}  // namespace
}  // namespace dadrl
