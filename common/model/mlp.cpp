#include "common/model/mlp.h"

#include <algorithm>

namespace dadrl {

using nn::kLanes;
using nn::LaneSpan;

namespace {

MlpActivations::Hidden TakeHidden(nn::Arena& arena, int features, int blocks, bool layer_norm) {
  MlpActivations::Hidden hidden;
  hidden.output = nn::TakeLanes(arena, features, blocks);
  if (!layer_norm) return hidden;
  hidden.normalized = nn::TakeLanes(arena, features, blocks);
  hidden.inverse_deviation = arena.Allocate(ptrdiff_t{blocks} * kLanes);
  return hidden;
}

void HiddenForward(const nn::LaneKernels& kernels, const nn::Linear& layer, const float* parameters,
                   LaneSpan input, int blocks, bool layer_norm, const MlpActivations::Hidden& hidden) {
  if (!layer_norm) return nn::LinearForward(kernels, layer, parameters, input, hidden.output, blocks, true);
  nn::LinearForward(kernels, layer, parameters, input, hidden.normalized, blocks, false);
  for (int b = 0; b < blocks; ++b) {
    float* normalized = hidden.normalized.block(b);
    kernels.layer_norm_forward(normalized, layer.outputs, normalized, hidden.inverse_deviation + b * kLanes);
    kernels.relu(normalized, hidden.output.block(b), static_cast<size_t>(layer.outputs) * kLanes);
  }
}

// From the gradient of the layer's output to that of its sums, in place.
void HiddenBackward(const nn::LaneKernels& kernels, int features, int blocks, bool layer_norm,
                    const MlpActivations::Hidden& hidden, LaneSpan gradient) {
  for (int b = 0; b < blocks; ++b) {
    kernels.relu_backward(hidden.output.block(b), gradient.block(b), static_cast<size_t>(features) * kLanes);
    if (layer_norm) {
      kernels.layer_norm_backward(hidden.normalized.block(b), hidden.inverse_deviation + b * kLanes, features,
                                  gradient.block(b));
    }
  }
}

}  // namespace

Mlp Mlp::Add(nn::ParamLayout& layout, const std::string& prefix, int inputs, int hidden, int outputs,
             bool layer_norm) {
  Mlp mlp;
  mlp.hidden1 = nn::Linear::Add(layout, prefix + ".hidden1", inputs, hidden);
  mlp.hidden2 = nn::Linear::Add(layout, prefix + ".hidden2", hidden, hidden);
  mlp.output = nn::Linear::Add(layout, prefix + ".output", hidden, outputs);
  mlp.layer_norm = layer_norm;
  return mlp;
}

MlpActivations::MlpActivations(nn::Arena& arena, const Mlp& mlp, int blocks)
    : hidden1(TakeHidden(arena, mlp.hidden1.outputs, blocks, mlp.layer_norm)),
      hidden2(TakeHidden(arena, mlp.hidden2.outputs, blocks, mlp.layer_norm)) {}

MlpScratch::MlpScratch(nn::Arena& arena, const Mlp& mlp, int blocks)
    : gradient1(nn::TakeLanes(arena, mlp.hidden1.outputs, blocks)),
      gradient2(nn::TakeLanes(arena, mlp.hidden2.outputs, blocks)),
      rows(arena.Allocate(nn::WeightScratch(std::max(mlp.hidden1.inputs, mlp.hidden2.inputs), blocks))) {}

void MlpForward(const nn::LaneKernels& kernels, const Mlp& mlp, const float* parameters, LaneSpan input,
                int blocks, const MlpActivations& activations, LaneSpan output) {
  HiddenForward(kernels, mlp.hidden1, parameters, input, blocks, mlp.layer_norm, activations.hidden1);
  HiddenForward(kernels, mlp.hidden2, parameters, activations.hidden1.output, blocks, mlp.layer_norm,
                activations.hidden2);
  nn::LinearForward(kernels, mlp.output, parameters, activations.hidden2.output, output, blocks, false);
}

void MlpBackward(const nn::LaneKernels& kernels, const Mlp& mlp, const float* parameters, LaneSpan input,
                 int blocks, const MlpActivations& activations, LaneSpan output_gradient,
                 const MlpGradients& gradients, const MlpScratch& scratch) {
  const bool weights = gradients.parameters != nullptr;
  const LaneSpan hidden1 = activations.hidden1.output;
  const LaneSpan hidden2 = activations.hidden2.output;
  if (weights) {
    nn::LinearWeightGradient(kernels, mlp.output, gradients.parameters, hidden2, output_gradient, blocks,
                             scratch.rows);
  }
  nn::LinearInputGradient(kernels, mlp.output, parameters, output_gradient, scratch.gradient2, 0,
                          mlp.output.inputs, blocks);
  HiddenBackward(kernels, mlp.hidden2.outputs, blocks, mlp.layer_norm, activations.hidden2,
                 scratch.gradient2);
  if (weights) {
    nn::LinearWeightGradient(kernels, mlp.hidden2, gradients.parameters, hidden1, scratch.gradient2, blocks,
                             scratch.rows);
  }
  nn::LinearInputGradient(kernels, mlp.hidden2, parameters, scratch.gradient2, scratch.gradient1, 0,
                          mlp.hidden2.inputs, blocks);
  HiddenBackward(kernels, mlp.hidden1.outputs, blocks, mlp.layer_norm, activations.hidden1,
                 scratch.gradient1);
  if (weights) {
    nn::LinearWeightGradient(kernels, mlp.hidden1, gradients.parameters, input, scratch.gradient1, blocks,
                             scratch.rows);
  }
  if (gradients.input.data != nullptr) {
    nn::LinearInputGradient(kernels, mlp.hidden1, parameters, scratch.gradient1, gradients.input,
                            gradients.first_input, gradients.input_count, blocks);
  }
}

}  // namespace dadrl
