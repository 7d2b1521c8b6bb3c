// Two hidden layers and a linear output: the policy's head and each critic.
#pragma once

#include "common/nn/aligned_buffer.h"
#include "common/nn/linear.h"

namespace dadrl {

// Each hidden layer is Linear, layer norm without affine if `layer_norm`, ReLU.
struct Mlp {
  static Mlp Add(nn::ParamLayout& layout, const std::string& prefix, int inputs, int hidden, int outputs,
                 bool layer_norm);

  nn::Linear hidden1;
  nn::Linear hidden2;
  nn::Linear output;
  bool layer_norm = false;
};

struct MlpActivations {
  MlpActivations() = default;
  MlpActivations(nn::Arena& arena, const Mlp& mlp, int blocks);

  struct Hidden {
    nn::LaneSpan normalized;             // before the ReLU; only with layer norm
    float* inverse_deviation = nullptr;  // [blocks][16], only with layer norm
    nn::LaneSpan output;                 // after the ReLU
  };
  Hidden hidden1;
  Hidden hidden2;
};

struct MlpScratch {
  MlpScratch() = default;
  MlpScratch(nn::Arena& arena, const Mlp& mlp, int blocks);

  nn::LaneSpan gradient1;
  nn::LaneSpan gradient2;
  float* rows = nullptr;
};

// input [blocks][inputs][16] to output [blocks][outputs][16].
void MlpForward(const nn::LaneKernels& kernels, const Mlp& mlp, const float* parameters, nn::LaneSpan input,
                int blocks, const MlpActivations& activations, nn::LaneSpan output);

// What a backward pass is asked for beyond output_gradient.
struct MlpGradients {
  float* parameters = nullptr;  // added to; null: none
  nn::LaneSpan input;           // [blocks][input_count][16], written; null data: none
  int first_input = 0;          // the part of the input whose gradient is wanted
  int input_count = 0;
};

void MlpBackward(const nn::LaneKernels& kernels, const Mlp& mlp, const float* parameters, nn::LaneSpan input,
                 int blocks, const MlpActivations& activations, nn::LaneSpan output_gradient,
                 const MlpGradients& gradients, const MlpScratch& scratch);

}  // namespace dadrl
