// Dense layers for a single sample: outputs in the vector lanes, weights packed once.
#pragma once

#include "common/nn/aligned_buffer.h"
#include "common/nn/linear.h"

namespace dadrl {

// Weights turned so that an output vector is a sum of rows: [inputs][outputs padded to 16]. Arena memory.
struct DenseRow {
  DenseRow() = default;
  DenseRow(nn::Arena& arena, int inputs, int outputs);

  // weight [outputs][inputs], row-major; bias [outputs], or null for none.
  void Pack(const float* weight, const float* bias);
  // The transpose: weight [inputs][outputs], row-major.
  void PackTransposed(const float* weight);

  // output [outputs padded] = W input + bias, the padding zero; rectified if `relu`.
  void Apply(const nn::LaneKernels& kernels, const float* input, float* output, bool relu) const;

  int inputs = 0;
  int outputs = 0;
  int padded = 0;
  float* weight = nullptr;
  float* bias = nullptr;
};

}  // namespace dadrl
