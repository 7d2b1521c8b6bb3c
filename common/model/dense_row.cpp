#include "common/model/dense_row.h"

#include <algorithm>

namespace dadrl {

using nn::kLanes;

DenseRow::DenseRow(nn::Arena& arena, int input_count, int output_count)
    : inputs(input_count),
      outputs(output_count),
      padded(nn::RoundUp(output_count, kLanes)),
      weight(arena.Allocate(inputs * padded)),
      bias(arena.Allocate(padded)) {}

void DenseRow::Pack(const float* from, const float* from_bias) {
  for (int i = 0; i < inputs; ++i) {
    for (int o = 0; o < outputs; ++o) weight[i * padded + o] = from[o * inputs + i];
  }
  if (from_bias != nullptr) std::copy_n(from_bias, outputs, bias);
}

void DenseRow::PackTransposed(const float* from) {
  for (int i = 0; i < inputs; ++i) {
    std::copy_n(from + i * outputs, outputs, weight + i * padded);
  }
}

void DenseRow::Apply(const nn::LaneKernels& kernels, const float* input, float* output, bool relu) const {
  std::copy_n(bias, padded, output);
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
