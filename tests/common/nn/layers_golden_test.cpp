// The layers against PyTorch in float64.
#include "common/nn/attention.h"
#include "common/nn/lstm.h"
#include "tests/common/nn/lane_test.h"
#include "tests/golden/golden.h"

namespace dadrl::nn {
namespace {

using golden::ExpectAgrees;
using golden::ExpectTensorsAgree;
using golden::Floats;
using golden::Uniform;

constexpr int kBatch = 18;
constexpr int kBlocks = 2;
constexpr int kUnits = 56;
constexpr int kVehicles = 6;
constexpr int kHistory = 5;

using LayersGolden = EveryIsa;

// Tensor `i` of the layout from salt + i, all with one scale.
FloatBuffer Parameters(const ParamLayout& layout, uint64_t salt, float scale) {
  FloatBuffer parameters(layout.size());
  for (const TensorInfo& tensor : layout.tensors()) {
    std::ranges::copy(Uniform(salt++, tensor.size, scale), parameters.data() + tensor.offset);
  }
  return parameters;
}

TEST_P(LayersGolden, LinearWithRelu) {
  ParamLayout layout;
  const Linear layer = Linear::Add(layout, "l", 19, 21);
  const FloatBuffer parameters = Parameters(layout, 10, 0.5f);
  FloatBuffer input = ToLaneBuffer(Uniform(12, kBatch * 19), kBatch, 19);
  FloatBuffer output = LaneBuffer(kBatch, 21);
  FloatBuffer gradient = ToLaneBuffer(Uniform(13, kBatch * 21), kBatch, 21);
  FloatBuffer input_gradient = LaneBuffer(kBatch, 19);
  FloatBuffer gradients(layout.size());
  FloatBuffer scratch(WeightScratch(19, kBlocks));
  const LaneSpan in = Contiguous(input.data(), 19);
  const LaneSpan out = Contiguous(output.data(), 21);
  LinearForward(kernels(), layer, parameters.data(), in, out, kBlocks, true);
  ExpectAgrees(ToRowVector(out, kBatch, 21), Floats("linear/output"), "output");

  kernels().relu_backward(output.data(), gradient.data(), gradient.size());
  const LaneSpan d_out = Contiguous(gradient.data(), 21);
  const LaneSpan d_in = Contiguous(input_gradient.data(), 19);
  LinearInputGradient(kernels(), layer, parameters.data(), d_out, d_in, 0, 19, kBlocks);
  ExpectAgrees(ToRowVector(d_in, kBatch, 19), Floats("linear/input_gradient"), "input");
  LinearWeightGradient(kernels(), layer, gradients.data(), in, d_out, kBlocks, scratch.data());
  ExpectTensorsAgree(layout, gradients.span(), Floats("linear/gradient"), "gradient of");
}

// The sequences of all vehicles, in blocks of sixteen sequences: [108, 5, 7].
FloatBuffer Sequences() { return ToLaneBuffer(Floats("inputs/vehicles0"), kBatch * kVehicles, kHistory * 7); }

TEST_P(LayersGolden, LstmOverPaddedHistories) {
  constexpr int kSequences = kBatch * kVehicles;
  const int blocks = BlocksOf(kSequences);
  ParamLayout layout;
  const Lstm lstm = Lstm::Add(layout, "lstm", 7, kUnits, kHistory);
  const FloatBuffer parameters = Parameters(layout, 20, 0.3f);
  const FloatBuffer sequences = Sequences();
  FloatBuffer last = LaneBuffer(kSequences, kUnits);
  const FloatBuffer last_gradient = ToLaneBuffer(Uniform(23, kSequences * kUnits), kSequences, kUnits);
  FloatBuffer gradients(layout.size());
  Arena measure;
  LstmActivations(measure, lstm, blocks, true);
  LstmActivations(measure, lstm, blocks, false);
  LstmScratch(measure, lstm);
  Arena arena(measure.used());
  const LstmActivations kept(arena, lstm, blocks, true);
  const LstmActivations passing(arena, lstm, blocks, false);
  const LstmScratch scratch(arena, lstm);

  LstmForward(kernels(), lstm, parameters.data(), sequences.data(), blocks, kept, last.data());
  const auto kept_rows = ToRowVector(Contiguous(last.data(), kUnits), kSequences, kUnits);
  ExpectAgrees(kept_rows, Floats("lstm/output"), "last hidden");
  LstmForward(kernels(), lstm, parameters.data(), sequences.data(), blocks, passing, last.data());
  EXPECT_EQ(ToRowVector(Contiguous(last.data(), kUnits), kSequences, kUnits), kept_rows);

  LstmBackward(kernels(), lstm, parameters.data(), gradients.data(), sequences.data(), blocks, kept,
               last_gradient.data(), scratch);
  ExpectTensorsAgree(layout, gradients.span(), Floats("lstm/gradient"), "gradient of");
}

TEST_P(LayersGolden, AttentionWithMaskedVehiclesAndNobody) {
  ParamLayout layout;
  const Attention attention = Attention::Add(layout, "a", kUnits, kVehicles);
  const FloatBuffer parameters = Parameters(layout, 30, 0.3f);
  constexpr int kHidden = (1 + kVehicles) * kUnits;
  FloatBuffer hidden = ToLaneBuffer(Uniform(40, kBatch * kHidden), kBatch, kHidden);
  const std::vector<float> vehicles = Floats("inputs/vehicles0");
  std::vector<float> absent_rows;
  for (size_t i = 0; i < size_t{kBatch} * kVehicles; ++i)
    absent_rows.push_back(vehicles[(i * kHistory + 4) * 7]);
  FloatBuffer absent = ToLaneBuffer(absent_rows, kBatch, kVehicles);
  FloatBuffer sum = LaneBuffer(kBatch, kUnits);
  FloatBuffer sum_gradient = ToLaneBuffer(Uniform(41, kBatch * kUnits), kBatch, kUnits);
  FloatBuffer hidden_gradient = LaneBuffer(kBatch, kHidden);
  FloatBuffer gradients(layout.size());
  Arena measure;
  AttentionActivations(measure, attention, kBlocks);
  AttentionScratch(measure, attention, kBlocks);
  Arena arena(measure.used());
  const AttentionActivations activations(arena, attention, kBlocks);
  const AttentionScratch scratch(arena, attention, kBlocks);
  const LaneSpan h = Contiguous(hidden.data(), kHidden);

  AttentionForward(kernels(), attention, parameters.data(), h, Contiguous(absent.data(), kVehicles), kBlocks,
                   activations, Contiguous(sum.data(), kUnits));
  ExpectAgrees(ToRowVector(Contiguous(sum.data(), kUnits), kBatch, kUnits), Floats("attention/output"),
               "sum");
  const std::vector<float> weights = ToRowVector(activations.weights, kBatch, kVehicles);
  ExpectAgrees(weights, Floats("attention/weights"), "weights");
  for (size_t i = 0; i < weights.size(); ++i) {
    if (absent_rows[i] > 0.5f) {
      EXPECT_EQ(weights[i], 0.0f) << "absent vehicle " << i;
    }
  }

  AttentionBackward(kernels(), attention, parameters.data(), gradients.data(), h, kBlocks, activations,
                    Contiguous(sum_gradient.data(), kUnits), Contiguous(hidden_gradient.data(), kHidden),
                    scratch);
  ExpectAgrees(ToRowVector(Contiguous(hidden_gradient.data(), kHidden), kBatch, kHidden),
               Floats("attention/hidden_gradient"), "hidden");
  ExpectTensorsAgree(layout, gradients.span(), Floats("attention/gradient"), "gradient of");
}

TEST_P(LayersGolden, LayerNorm) {
  FloatBuffer values = ToLaneBuffer(Uniform(42, kBatch * kUnits), kBatch, kUnits);
  FloatBuffer gradient = ToLaneBuffer(Uniform(43, kBatch * kUnits), kBatch, kUnits);
  FloatBuffer inverse_deviation(kBlocks * kLanes);
  const LaneSpan span = Contiguous(values.data(), kUnits);
  const LaneSpan d = Contiguous(gradient.data(), kUnits);
  for (int b = 0; b < kBlocks; ++b) {
    float* inverse = inverse_deviation.data() + b * kLanes;
    kernels().layer_norm_forward(span.block(b), kUnits, span.block(b), inverse);
    kernels().layer_norm_backward(span.block(b), inverse, kUnits, d.block(b));
  }
  ExpectAgrees(ToRowVector(span, kBatch, kUnits), Floats("layer_norm/output"), "output");
  ExpectAgrees(ToRowVector(d, kBatch, kUnits), Floats("layer_norm/input_gradient"), "input");
}

INSTANTIATE_TEST_SUITE_P(Isa, LayersGolden, AllIsas(), IsaTestName);

}  // namespace
}  // namespace dadrl::nn
