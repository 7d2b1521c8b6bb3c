#include "common/model/context_encoder.h"

#include <cmath>

namespace dadrl {

using nn::kConvFeatures;
using nn::kLanes;

ContextEncoder ContextEncoder::Add(nn::ParamLayout& layout, const std::string& prefix) {
  ContextEncoder encoder;
  for (size_t i = 0; i < nn::kConvLayers; ++i) {
    const auto [out, in, kernel, weights] = nn::kConvLayerShapes[i];
    const std::string name = prefix + ".conv" + std::to_string(i + 1);
    const float bound = 1.0f / std::sqrt(static_cast<float>(weights / out));
    encoder.conv_weight[i] = layout.Add(name + ".weight", {out, in, kernel, kernel}, bound);
    encoder.conv_bias[i] = layout.Add(name + ".bias", {out}, bound);
  }
  encoder.output = nn::Linear::Add(layout, prefix + ".output", kConvFeatures, kFeatures);
  return encoder;
}

nn::ConvStackParams ContextEncoder::ConvParams(const float* parameters) const {
  nn::ConvStackParams params{};
  for (size_t i = 0; i < conv_weight.size(); ++i) {
    params.weight[i] = parameters + conv_weight[i];
    params.bias[i] = parameters + conv_bias[i];
  }
  return params;
}

nn::ConvStackGrads ContextEncoder::ConvGrads(float* gradients) const {
  nn::ConvStackGrads grads{};
  for (size_t i = 0; i < conv_weight.size(); ++i) {
    grads.weight[i] = gradients + conv_weight[i];
    grads.bias[i] = gradients + conv_bias[i];
  }
  return grads;
}

ContextActivations::ContextActivations(nn::Arena& arena, int blocks, bool keep_all)
    : keep(keep_all),
      conv(arena.Allocate(nn::ConvStackActivationBytes(blocks * kLanes, keep_all) / sizeof(float))),
      pooled(nn::TakeLanes(arena, kConvFeatures, blocks)) {}

ContextScratch::ContextScratch(nn::Arena& arena, int blocks)
    : pooled_gradient(nn::TakeLanes(arena, kConvFeatures, blocks)),
      rows(arena.Allocate(nn::WeightScratch(kConvFeatures, blocks))) {}

void ContextForward(const nn::LaneKernels& kernels, const ContextEncoder& encoder, const float* parameters,
                    const LaneObservations& observations, const ContextActivations& activations,
                    nn::LaneSpan features) {
  const int blocks = observations.blocks;
  nn::ConvStackForward(observations.context_planes, blocks * kLanes, encoder.ConvParams(parameters),
                       activations.conv, activations.pooled.data, activations.keep);
  nn::LinearForward(kernels, encoder.output, parameters, activations.pooled, features, blocks, true);
}

void ContextBackward(const nn::LaneKernels& kernels, const ContextEncoder& encoder, const float* parameters,
                     float* gradients, const LaneObservations& observations,
                     const ContextActivations& activations, nn::LaneSpan feature_gradient,
                     const ContextScratch& scratch) {
  const int blocks = observations.blocks;
  nn::LinearWeightGradient(kernels, encoder.output, gradients, activations.pooled, feature_gradient, blocks,
                           scratch.rows);
  nn::LinearInputGradient(kernels, encoder.output, parameters, feature_gradient, scratch.pooled_gradient, 0,
                          kConvFeatures, blocks);
  nn::ConvStackBackward(observations.context_planes, blocks * kLanes, encoder.ConvParams(parameters),
                        activations.conv, scratch.pooled_gradient.data, encoder.ConvGrads(gradients));
}

}  // namespace dadrl
