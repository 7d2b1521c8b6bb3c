#include "common/nn/linear.h"

#include <cmath>

namespace dadrl::nn {
namespace {

int PaddedRow(int inputs) { return RoundUp(inputs, kLanes); }

}  // namespace

LaneSpan TakeLanes(Arena& arena, int features, int blocks) {
  return Contiguous(arena.Allocate(ptrdiff_t{features} * kLanes * blocks), features);
}

Linear Linear::Add(ParamLayout& layout, const std::string& prefix, int inputs, int outputs) {
  const float bound = 1.0f / std::sqrt(static_cast<float>(inputs));
  Linear layer{.inputs = inputs, .outputs = outputs};
  layer.weight = layout.Add(prefix + ".weight", {outputs, inputs}, bound);
  layer.bias = layout.Add(prefix + ".bias", {outputs}, bound);
  return layer;
}

void LinearForward(const LaneKernels& kernels, const Linear& layer, const float* parameters, LaneSpan input,
                   LaneSpan output, int blocks, bool relu) {
  kernels.multiply({.rows = layer.outputs,
                    .blocks = blocks,
                    .depth = layer.inputs,
                    .a = parameters + layer.weight,
                    .a_row = layer.inputs,
                    .a_depth = 1,
                    .b = input.data,
                    .b_block = input.block_stride,
                    .b_depth = kLanes,
                    .c = output.data,
                    .c_block = output.block_stride,
                    .c_row = kLanes,
                    .bias = parameters + layer.bias,
                    .relu = relu});
}

void LinearInputGradient(const LaneKernels& kernels, const Linear& layer, const float* parameters,
                         LaneSpan output_gradient, LaneSpan input_gradient, int first, int count,
                         int blocks) {
  kernels.multiply({.rows = count,
                    .blocks = blocks,
                    .depth = layer.outputs,
                    .a = parameters + layer.weight + first,
                    .a_row = 1,
                    .a_depth = layer.inputs,
                    .b = output_gradient.data,
                    .b_block = output_gradient.block_stride,
                    .b_depth = kLanes,
                    .c = input_gradient.data,
                    .c_block = input_gradient.block_stride,
                    .c_row = kLanes});
}

void LinearWeightGradient(const LaneKernels& kernels, const Linear& layer, float* gradients, LaneSpan input,
                          LaneSpan output_gradient, int blocks, float* scratch) {
  kernels.sum_samples(output_gradient.data, output_gradient.block_stride, blocks, layer.outputs,
                      gradients + layer.bias);
  OuterProductSum(kernels, output_gradient, layer.outputs, input, layer.inputs, blocks,
                  gradients + layer.weight, scratch);
}

void OuterProductSum(const LaneKernels& kernels, LaneSpan output_gradient, int outputs, LaneSpan input,
                     int inputs, int blocks, float* weight_gradient, float* scratch) {
  const int row = PaddedRow(inputs);
  for (int block = 0; block < blocks; ++block) {
    kernels.to_rows(input.block(block), inputs, scratch + ptrdiff_t{block} * row * kLanes, row);
  }
  kernels.multiply({.rows = outputs,
                    .blocks = row / kLanes,
                    .depth = kLanes,
                    .segments = blocks,
                    .a = output_gradient.data,
                    .a_row = kLanes,
                    .a_depth = 1,
                    .a_segment = output_gradient.block_stride,
                    .b = scratch,
                    .b_block = kLanes,
                    .b_depth = row,
                    .b_segment = ptrdiff_t{row} * kLanes,
                    .c = weight_gradient,
                    .c_block = kLanes,
                    .c_row = inputs,
                    .accumulate = true,
                    .last_width = inputs - row + kLanes});
}

size_t WeightScratch(int inputs, int blocks) {
  return static_cast<size_t>(PaddedRow(inputs)) * kLanes * static_cast<size_t>(blocks);
}

}  // namespace dadrl::nn
