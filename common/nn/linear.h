// The dense layer, forward and backward, on batch-in-lanes activations.
#pragma once

#include <cstddef>
#include <string>

#include "common/nn/aligned_buffer.h"
#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/param_layout.h"

namespace dadrl::nn {

// Activations [blocks][features][16] whose blocks may lie further apart than their features need, so that a
// layer can read or write some features of a wider array. Lent.
struct LaneSpan {
  float* data = nullptr;
  ptrdiff_t block_stride = 0;  // in floats

  // The same blocks from feature `first` on.
  LaneSpan From(int first) const { return {data + ptrdiff_t{first} * kLanes, block_stride}; }
  float* block(int index) const { return data + index * block_stride; }
};

// A contiguous [blocks][features][16].
inline LaneSpan Contiguous(float* data, int features) { return {data, ptrdiff_t{features} * kLanes}; }

// Such an array of an arena, zeroed at first.
LaneSpan TakeLanes(Arena& arena, int features, int blocks);

// y = W x + b; `weight` and `bias` are offsets into the flat parameter vector, weight [outputs][inputs].
struct Linear {
  int inputs = 0;
  int outputs = 0;
  size_t weight = 0;
  size_t bias = 0;

  // Adds "<prefix>.weight" and "<prefix>.bias", initialised as PyTorch does: uniform within 1 / sqrt(inputs).
  static Linear Add(ParamLayout& layout, const std::string& prefix, int inputs, int outputs);
};

// output [blocks][outputs][16] = W input + b, rectified if `relu`.
void LinearForward(const LaneKernels& kernels, const Linear& layer, const float* parameters, LaneSpan input,
                   LaneSpan output, int blocks, bool relu);

// input_gradient [blocks][count][16] = rows `first` .. `first + count` of W^T output_gradient.
void LinearInputGradient(const LaneKernels& kernels, const Linear& layer, const float* parameters,
                         LaneSpan output_gradient, LaneSpan input_gradient, int first, int count, int blocks);

// gradients(W, b) += sum over samples of output_gradient input^T. `scratch` holds WeightScratch(inputs,
// blocks) floats.
void LinearWeightGradient(const LaneKernels& kernels, const Linear& layer, float* gradients, LaneSpan input,
                          LaneSpan output_gradient, int blocks, float* scratch);

// weight_gradient [outputs][inputs] += the same, without a bias; for products that are no Linear.
void OuterProductSum(const LaneKernels& kernels, LaneSpan output_gradient, int outputs, LaneSpan input,
                     int inputs, int blocks, float* weight_gradient, float* scratch);

size_t WeightScratch(int inputs, int blocks);

}  // namespace dadrl::nn
