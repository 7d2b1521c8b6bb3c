#include "common/model/dense_row.h"

#include <cstring>

namespace dadrl {

using nn::kLanes;

DenseRow::DenseRow(nn::Arena& arena, int input_count, int output_count)
    : inputs(input_count),
      outputs(output_count),
      padded(static_cast<int>(nn::RoundUp(static_cast<size_t>(output_count), kLanes))),
      weight(arena.Allocate(static_cast<size_t>(inputs) * static_cast<size_t>(padded))),
      bias(arena.Allocate(static_cast<size_t>(padded))) {}

void DenseRow::Pack(const float* from, const float* from_bias) {
  for (int i = 0; i < inputs; ++i) {
    for (int o = 0; o < outputs; ++o) weight[i * padded + o] = from[o * inputs + i];
  }
  if (from_bias != nullptr) std::memcpy(bias, from_bias, static_cast<size_t>(outputs) * sizeof(float));
}

void DenseRow::PackTransposed(const float* from) {
  for (int i = 0; i < inputs; ++i) {
    std::memcpy(weight + i * padded, from + i * outputs, static_cast<size_t>(outputs) * sizeof(float));
  }
}

void DenseRow::Apply(const nn::LaneKernels& kernels, const float* input, float* output, bool relu) const {
  std::memcpy(output, bias, static_cast<size_t>(padded) * sizeof(float));
  kernels.multiply({.rows = 1,
                    .blocks = padded / kLanes,
                    .depth = inputs,
                    .a = input,
                    .a_depth = 1,
                    .b = weight,
                    .b_block = kLanes,
                    .b_depth = padded,
                    .c = output,
                    .c_block = kLanes,
                    .accumulate = true,
                    .relu = relu});
}

}  // namespace dadrl
