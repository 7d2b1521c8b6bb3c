// The context encoder (paper, section IV): the bird's-eye planes to 128 features.
#pragma once

#include <array>

#include "common/model/lane_observations.h"
#include "common/nn/kernels/conv_stack.h"

namespace dadrl {

// Five convolutions (common/nn/kernels/conv_stack.h), Linear(256 -> 128), ReLU.
struct ContextEncoder {
  static constexpr int kFeatures = 128;

  static ContextEncoder Add(nn::ParamLayout& layout, const std::string& prefix);
  // Views of the convolutions' tensors in a flat vector.
  nn::ConvStackParams ConvParams(const float* parameters) const;
  nn::ConvStackGrads ConvGrads(float* gradients) const;

  std::array<size_t, nn::kConvLayers> conv_weight{};  // offsets
  std::array<size_t, nn::kConvLayers> conv_bias{};
  nn::Linear output;
};

struct ContextActivations {
  ContextActivations() = default;
  ContextActivations(nn::Arena& arena, int blocks, bool keep);

  bool keep = false;
  float* conv = nullptr;  // working memory of the convolutions
  nn::LaneSpan pooled;    // [blocks][256][16], of the convolutions
};

struct ContextScratch {
  ContextScratch() = default;
  ContextScratch(nn::Arena& arena, int blocks);

  nn::LaneSpan pooled_gradient;
  float* rows = nullptr;
};

// features [blocks][128][16].
void ContextForward(const nn::LaneKernels& kernels, const ContextEncoder& encoder, const float* parameters,
                    const LaneObservations& observations, const ContextActivations& activations,
                    nn::LaneSpan features);

// gradients: those of the convolutions are overwritten, the rest added to. feature_gradient must already be
// zero where the feature is not positive.
void ContextBackward(const nn::LaneKernels& kernels, const ContextEncoder& encoder, const float* parameters,
                     float* gradients, const LaneObservations& observations,
                     const ContextActivations& activations, nn::LaneSpan feature_gradient,
                     const ContextScratch& scratch);

}  // namespace dadrl
