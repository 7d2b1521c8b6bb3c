// Sums of the first layer's weights for every pattern of five neighbouring bits.
#pragma once

#include "common/nn/kernels/conv_params.h"

namespace dadrl::nn::simd {

constexpr int kKernelRows1 = Conv1::kIn * Conv1::kKernel;  // (plane, ky)
constexpr int kPatterns = 1 << Conv1::kKernel;

// sum of the taps of kernel row `row` of channel co whose bits are set in pattern.
template <class Simd>
float PatternSum(const float* weight, int co, int row, int pattern) {
  const float* const taps = weight + (co * kKernelRows1 + row) * Conv1::kKernel;
  float sum = 0;
  for (int kx = 0; kx < Conv1::kKernel; ++kx) sum += ((pattern >> kx) & 1) != 0 ? taps[kx] : 0.0F;
  return sum;
}

// Zero, or NaN if a weight is not finite: added to the bias it surfaces even where no bit selects that
// weight.
template <class Simd>
float NonFiniteMark(const float* weight) {
  float sum = 0;
  for (int i = 0; i < Conv1::kWeights; ++i) sum += 0.0F * weight[i];
  return sum;
}

}  // namespace dadrl::nn::simd
