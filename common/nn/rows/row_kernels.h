// The arithmetic of a graph's nodes on rows of features that is no dense product (lanes/lane_kernels.h has
// that), compiled once per instruction set.
//
// Arrays are [rows][stride] float32, 64-byte aligned; the stride is the features rounded up to sixteen, and
// the padding is zero and stays zero.
#pragma once

#include <cstddef>

#include "common/nn/kernels/lane_count.h"
#include "common/util/isa.h"

namespace dadrl::nn {

// Rows of attention scores, [queries][stride], one column a key.
struct ScoreRows {
  int queries = 0;
  int keys = 0;
  ptrdiff_t stride = 0;
  float* scores = nullptr;         // forward: in scores, out weights. Backward: in gradient of the weights,
                                   // out gradient of the scores before scaling
  const float* weights = nullptr;  // backward: the forward pass's
  const float* absent = nullptr;   // [keys][absent_stride], 1 where masked; null: none is
  ptrdiff_t absent_stride = kLanes;
  bool causal = false;  // query i sees the keys up to i alone
  float scale = 1.0f;
};

// Rows through layer norm: y = gain n + bias, n the features less their mean over their deviation, where
// the gain is stored less one.
struct NormRows {
  int rows = 0;
  int features = 0;
  ptrdiff_t stride = 0;
  const float* gain = nullptr;         // [features, padded]
  const float* bias = nullptr;         // [features, padded]
  const float* input = nullptr;        // forward
  float* output = nullptr;             // forward
  float* normalized = nullptr;         // [rows][stride], written forward, read backward
  float* inverse_deviation = nullptr;  // [rows], the same
  // Backward only.
  const float* output_gradient = nullptr;
  float* input_gradient = nullptr;  // added to; null: nobody wants it
  float* gain_gradient = nullptr;   // [features, padded], added to
  float* bias_gradient = nullptr;
};

struct RowKernels {
  // Weights are zero for what is masked; all of them are where nothing is left to attend to.
  void (*softmax_forward)(const ScoreRows&);
  void (*softmax_backward)(const ScoreRows&);
  void (*layer_norm_forward)(const NormRows&);
  void (*layer_norm_backward)(const NormRows&);
  // output = tanh(input); `count` a multiple of 16.
  void (*tanh)(const float* input, float* output, size_t count);
  // input_gradient += output_gradient (1 - output^2).
  void (*tanh_backward)(const float* output, const float* output_gradient, float* input_gradient,
                        size_t count);
  // input_gradient += output_gradient where output is positive.
  void (*relu_backward)(const float* output, const float* output_gradient, float* input_gradient,
                        size_t count);
  // sum += addend.
  void (*add)(const float* addend, float* sum, size_t count);
  // sums [stride] += the sum of the rows.
  void (*sum_rows)(const float* rows, int count, ptrdiff_t stride, float* sums);
};

// The kernels for one instruction set; asking for one this processor lacks is a programmer's mistake.
const RowKernels& RowKernelsFor(Isa isa);

}  // namespace dadrl::nn
