// Adam over a flat parameter vector, with the target network's Polyak step in the same pass.
#pragma once

#include <cstdint>
#include <span>

#include "common/nn/aligned_buffer.h"
#include "common/nn/lanes/lane_kernels.h"

namespace dadrl::nn {

// Kingma and Ba (2015) with PyTorch's defaults and arrangement: p -= lr m' / (sqrt(v') + epsilon).
struct AdamSettings {
  double learning_rate = 1e-3;
  double beta1 = 0.9;
  double beta2 = 0.999;
  double epsilon = 1e-8;
};

// First and second moments, in the layout of the gradients.
struct AdamMoments {
  explicit AdamMoments(size_t count) : first(count), second(count) {}
  FloatBuffer first;
  FloatBuffer second;
};

// The part [first, first + count) of a gradient vector, both multiples of 16.
struct Range {
  size_t first = 0;
  size_t count = 0;
};

// Member `member` of `members` equal shares of `whole`.
Range ShareOf(Range whole, int member, int members);

// Where an optimiser step reads and writes; every pointer is to the start of the gradients' layout except
// `parameters` and `target`, which are to the elements that gradient `range.first` belongs to.
struct AdamStep {
  Range range;
  float* parameters = nullptr;
  float* target = nullptr;  // null: none
  double tau = 0.0;
  AdamMoments* moments = nullptr;
  std::span<float* const> gradients;  // one vector a thread, summed in order; zeroed
  uint64_t step = 1;                  // 1 for the first
};

// False when a parameter of the range is no longer finite. Threads may work on disjoint ranges. At most
// kMaxGradients gradient vectors.
constexpr int kMaxGradients = 256;
bool ApplyAdam(const LaneKernels& kernels, const AdamSettings& settings, const AdamStep& step);

// One scalar, in double: the temperature.
struct ScalarAdam {
  double value = 0.0;
  double first = 0.0;
  double second = 0.0;
};
void ApplyAdam(const AdamSettings& settings, double gradient, uint64_t step, ScalarAdam& scalar);

}  // namespace dadrl::nn
