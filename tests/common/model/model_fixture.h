// Golden observations and networks on every instruction set, for the tests of common/model.
#pragma once

#include "common/model/networks.h"
#include "tests/common/nn/lane_test.h"
#include "tests/driving_columns.h"
#include "tests/golden/golden.h"
#include "tests/golden/scene_ways.h"

namespace dadrl {

constexpr int kGoldenBatch = 18;

// Observation batch `index` of the golden inputs.
inline Columns GoldenObservations(int index) {
  Columns batch(DrivingShape{}, kGoldenBatch);
  const std::string suffix = std::to_string(index);
  std::ranges::copy(golden::Floats("inputs/vehicles" + suffix), VehiclesOf(batch).begin());
  std::ranges::copy(golden::Floats("inputs/ego" + suffix), EgoOf(batch).begin());
  std::ranges::copy(golden::Bytes("inputs/context" + suffix), ContextOf(batch).begin());
  return batch;
}

// The same with polylines: those of make_scene_golden.py.
inline Columns GoldenScenes(int index) {
  const DrivingShape shape{.polylines = true};
  Columns batch(shape, kGoldenBatch);
  const Columns without = GoldenObservations(index);
  std::ranges::copy(VehiclesOf(without), VehiclesOf(batch).begin());
  std::ranges::copy(EgoOf(without), EgoOf(batch).begin());
  std::ranges::copy(ContextOf(without), ContextOf(batch).begin());
  FillWays(shape, index, batch);
  return batch;
}

inline Observation OneOf(const Columns& batch, const DrivingShape& spec, int sample) {
  Observation observation(spec);
  const ColumnRows row(batch, sample, 1);
  for (size_t i = 0; i < batch.columns(); ++i) {
    std::ranges::copy(row.floats(i), observation.floats(i).begin());
    std::ranges::copy(row.bits(i), observation.bits(i).begin());
  }
  return observation;
}

// An encoder's memory and its passes over one batch, for the instruction set in use.
class EncoderRun {
 public:
  EncoderRun(const Encoder& encoder, const Columns& batch, bool keep)
      : encoder_(encoder), kernels_(nn::LaneKernelsFor(ActiveIsa())), batch_(batch), samples_(batch.rows()) {
    const int blocks = nn::BlocksOf(batch.rows());
    nn::Arena measure;
    LayOut(measure, blocks, keep);
    arena_ = nn::Arena(measure.used());
    LayOut(arena_, blocks, keep);
    context_.assign(ContextOf(batch).begin(), ContextOf(batch).end());
    context_.resize(static_cast<size_t>(blocks) * nn::kLanes * DrivingShape::kContextBytes);
    observations_.Pack(kernels_, batch_, context_.data(), 0);
  }

  std::vector<float> Forward(const float* parameters) {
    EncoderForward(kernels_, encoder_, parameters, observations_, activations_, features_);
    return nn::ToRowVector(features_, samples_, encoder_.features());
  }

  // feature_gradient [samples, features].
  void Backward(const float* parameters, const std::vector<float>& feature_gradient, float* gradients) {
    nn::FloatBuffer lanes = nn::ToLaneBuffer(feature_gradient, samples_, encoder_.features());
    EncoderBackward(kernels_, encoder_, parameters, gradients, observations_, activations_, features_,
                    nn::Contiguous(lanes.data(), encoder_.features()), scratch_);
  }

  const EncoderActivations& activations() const { return activations_; }
  nn::LaneSpan features() const { return features_; }

 private:
  void LayOut(nn::Arena& arena, int blocks, bool keep) {
    observations_ = LaneObservations(arena, encoder_.spec, blocks);
    activations_ = EncoderActivations(arena, encoder_, blocks, keep);
    scratch_ = EncoderScratch(arena, encoder_, blocks);
    features_ = nn::Contiguous(arena.Allocate(static_cast<size_t>(blocks * encoder_.features() * nn::kLanes)),
                               encoder_.features());
  }

  const Encoder& encoder_;
  const nn::LaneKernels& kernels_;
  const Columns batch_;  // observations_ borrows it
  int samples_;
  nn::Arena arena_;
  std::vector<uint8_t> context_;
  LaneObservations observations_;
  EncoderActivations activations_;
  EncoderScratch scratch_;
  nn::LaneSpan features_;
};

// [samples, 4]: mean and log std of the batched path.
inline std::vector<float> BatchedOutput(const PolicyNetwork& network, const std::vector<float>& parameters,
                                        EncoderRun& run, int samples) {
  nn::FloatBuffer aligned(parameters.size());
  std::ranges::copy(parameters, aligned.data());
  run.Forward(aligned.data());
  const int blocks = nn::BlocksOf(samples);
  nn::Arena measure;
  MlpActivations(measure, network.head, blocks);
  nn::Arena arena(measure.used());
  const MlpActivations activations(arena, network.head, blocks);
  nn::FloatBuffer output = nn::LaneBuffer(samples, 4);
  MlpForward(nn::LaneKernelsFor(ActiveIsa()), network.head, aligned.data(), run.features(), blocks,
             activations, nn::Contiguous(output.data(), 4));
  return nn::ToRowVector(nn::Contiguous(output.data(), 4), samples, 4);
}

// Chooses the instruction set for the test and puts the former one back.
class ModelOnEveryIsa : public nn::EveryIsa {
 protected:
  void SetUp() override {
    EveryIsa::SetUp();
    if (!IsSkipped()) {
      ASSERT_TRUE(SetIsa(GetParam()));
    }
  }
  void TearDown() override { SetIsa(before_); }

 private:
  Isa before_ = ActiveIsa();
};

}  // namespace dadrl
