#include "common/model/encoder.h"

#include <algorithm>
#include <cstring>

namespace dadrl {

using nn::kLanes;

namespace {

// Samples of the batch among the observations' blocks.
int SamplesOf(const LaneObservations& observations) {
  return std::clamp(observations.rows->rows() - observations.first_row, 0, observations.blocks * kLanes);
}

// A graph has samples in rows, the layers around it in lanes.
void SceneForward(const nn::LaneKernels& kernels, const SceneEncoder& scene, const float* parameters,
                  const LaneObservations& observations, nn::Tape& tape, nn::LaneSpan features) {
  const int samples = SamplesOf(observations);
  for (int i = 0; i < samples; ++i) {
    PackScene(scene, *observations.rows, observations.first_row + i, tape, i);
  }
  tape.Forward(parameters, samples);
  constexpr ptrdiff_t kRow = SceneEncoder::kFeatures;
  for (int b = 0; b < observations.blocks; ++b) {
    kernels.to_lanes(tape.value(scene.features) + b * kLanes * kRow, kRow,
                     std::clamp(samples - b * kLanes, 0, kLanes), SceneEncoder::kFeatures, features.block(b));
  }
}

void SceneBackward(const nn::LaneKernels& kernels, const SceneEncoder& scene, const float* parameters,
                   float* gradients, const LaneObservations& observations, nn::Tape& tape,
                   nn::LaneSpan feature_gradient) {
  tape.BeginBackward();
  constexpr ptrdiff_t kRow = SceneEncoder::kFeatures;
  for (int b = 0; b < observations.blocks; ++b) {
    kernels.to_rows(feature_gradient.block(b), SceneEncoder::kFeatures,
                    tape.gradient(scene.features) + b * kLanes * kRow, kRow);
  }
  tape.Backward(parameters, gradients);
}

}  // namespace

Encoder Encoder::Add(nn::ParamLayout& layout, const std::string& prefix, const DrivingShape& spec,
                     const ModelConfig& model) {
  Encoder encoder;
  encoder.spec = spec;
  if (model.stae) encoder.stae = Stae::Add(layout, prefix + ".stae", spec);
  if (model.scene) encoder.scene = SceneEncoder::Add(layout, prefix + ".scene", spec);
  if (model.context) encoder.context = ContextEncoder::Add(layout, prefix + ".context");
  return encoder;
}

EncoderActivations::EncoderActivations(nn::Arena& arena, const Encoder& encoder, int blocks, bool keep) {
  if (encoder.stae) stae = StaeActivations(arena, *encoder.stae, blocks, keep);
  if (encoder.scene) scene = std::make_unique<nn::Tape>(arena, encoder.scene->graph, blocks * kLanes, keep);
  if (encoder.context) context = ContextActivations(arena, blocks, keep);
}

EncoderScratch::EncoderScratch(nn::Arena& arena, const Encoder& encoder, int blocks) {
  if (encoder.stae) stae = StaeScratch(arena, *encoder.stae, blocks);
  if (encoder.context) context = ContextScratch(arena, blocks);
}

void EncoderForward(const nn::LaneKernels& kernels, const Encoder& encoder, const float* parameters,
                    const LaneObservations& observations, const EncoderActivations& activations,
                    nn::LaneSpan features) {
  if (encoder.scene) {
    SceneForward(kernels, *encoder.scene, parameters, observations, *activations.scene, features);
  } else if (encoder.stae) {
    StaeForward(kernels, *encoder.stae, parameters, observations, activations.stae, features);
  } else {
    const ptrdiff_t ego = EgoBlock(encoder.spec);
    const ptrdiff_t sequence = SequenceFloats(encoder.spec);
    for (int b = 0; b < observations.blocks; ++b) {
      const float* vehicles = observations.sequences + ((1 + encoder.spec.vehicles) * b + 1) * sequence;
      std::copy_n(observations.ego + b * ego, ego, features.block(b));
      std::memcpy(features.block(b) + ego, vehicles,
                  static_cast<size_t>(encoder.spec.vehicles * sequence) * sizeof(float));
    }
  }
  if (encoder.context) {
    ContextForward(kernels, *encoder.context, parameters, observations, activations.context,
                   features.From(encoder.vehicle_features()));
  }
}

void EncoderBackward(const nn::LaneKernels& kernels, const Encoder& encoder, const float* parameters,
                     float* gradients, const LaneObservations& observations,
                     const EncoderActivations& activations, nn::LaneSpan features,
                     nn::LaneSpan feature_gradient, const EncoderScratch& scratch) {
  for (int b = 0; b < observations.blocks; ++b) {
    kernels.relu_backward(features.block(b), feature_gradient.block(b),
                          static_cast<size_t>(encoder.features()) * kLanes);
  }
  if (encoder.stae) {
    StaeBackward(kernels, *encoder.stae, parameters, gradients, observations, activations.stae,
                 feature_gradient, scratch.stae);
  }
  if (encoder.scene) {
    SceneBackward(kernels, *encoder.scene, parameters, gradients, observations, *activations.scene,
                  feature_gradient);
  }
  if (encoder.context) {
    ContextBackward(kernels, *encoder.context, parameters, gradients, observations, activations.context,
                    feature_gradient.From(encoder.vehicle_features()), scratch.context);
  }
}

}  // namespace dadrl
