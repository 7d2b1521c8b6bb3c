// Observation to state: what policy and critics see (paper, section IV; design, section 5).
#pragma once

#include <memory>
#include <optional>

#include "common/model/context_encoder.h"
#include "common/model/scene_encoder.h"
#include "common/model/stae.h"

namespace dadrl {

// [vehicle part, context part]: 128 features of the STAE (model.stae) or of the scene encoder (model.scene),
// or without either the raw ego and vehicle tensors; then 128 of the context encoder, or without it nothing.
struct Encoder {
  static Encoder Add(nn::ParamLayout& layout, const std::string& prefix, const DrivingShape& spec,
                     const ModelConfig& model);

  int features() const { return vehicle_features() + (context ? ContextEncoder::kFeatures : 0); }
  int vehicle_features() const {
    if (scene) return SceneEncoder::kFeatures;
    return stae ? Stae::kFeatures : spec.ego_floats() + spec.vehicle_floats();
  }

  DrivingShape spec;
  std::optional<Stae> stae;
  std::optional<SceneEncoder> scene;
  std::optional<ContextEncoder> context;
};

struct EncoderActivations {
  EncoderActivations() = default;
  // Without `keep` there is nothing for a backward pass, and far less memory.
  EncoderActivations(nn::Arena& arena, const Encoder& encoder, int blocks, bool keep);

  StaeActivations stae;
  std::unique_ptr<nn::Tape> scene;
  ContextActivations context;
};

struct EncoderScratch {
  EncoderScratch() = default;
  EncoderScratch(nn::Arena& arena, const Encoder& encoder, int blocks);

  StaeScratch stae;
  ContextScratch context;
};

// features [blocks][encoder.features()][16].
void EncoderForward(const nn::LaneKernels& kernels, const Encoder& encoder, const float* parameters,
                    const LaneObservations& observations, const EncoderActivations& activations,
                    nn::LaneSpan features);

// Adds to `gradients`, which must be zero where the convolutions' lie. feature_gradient is overwritten;
// `features` and the kept activations are the forward pass's.
void EncoderBackward(const nn::LaneKernels& kernels, const Encoder& encoder, const float* parameters,
                     float* gradients, const LaneObservations& observations,
                     const EncoderActivations& activations, nn::LaneSpan features,
                     nn::LaneSpan feature_gradient, const EncoderScratch& scratch);

}  // namespace dadrl
