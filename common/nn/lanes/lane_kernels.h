// The arithmetic of the layers on batch-in-lanes activations, compiled once per instruction set.
//
// Activations are stored in blocks of sixteen samples: [block][feature][16], so that every operation over the
// batch is a whole-vector operation, a dense product is a broadcast weight times a vector without packing or
// padding of channels, and the convolution stack's output is read in place. Unused samples of the last block
// hold zeros and are given zero gradients by the loss. All arrays are 64-byte aligned float32 unless said
// otherwise.
//
// Dense products are ours rather than Eigen's because in this layout they need no packing, and no template
// that the linker could merge across instruction sets: tests/bench/dense_product measures both on this
// network's shapes.
#pragma once

#include <cstddef>

#include "common/nn/kernels/lane_count.h"
#include "common/util/isa.h"

namespace dadrl::nn {

constexpr float kLayerNormEpsilon = 1e-5f;

// C[n][i][.] = bias[i] + sum over s < segments, k < depth of A(i, s, k) * B[n](s, k)[.], for `rows` i and
// `blocks` n. Strides in floats. Forward products have A = weights and blocks of samples; weight gradients
// have A = output gradients, blocks of sixteen inputs, and segments of sixteen samples.
struct Product {
  int rows = 0;
  int blocks = 0;
  int depth = 0;
  int segments = 1;
  const float* a = nullptr;
  ptrdiff_t a_row = 0;
  ptrdiff_t a_depth = 0;
  ptrdiff_t a_segment = 0;
  const float* b = nullptr;
  ptrdiff_t b_block = 0;
  ptrdiff_t b_depth = 0;
  ptrdiff_t b_segment = 0;
  float* c = nullptr;
  ptrdiff_t c_block = 0;
  ptrdiff_t c_row = 0;
  const float* bias = nullptr;  // [rows]; null is zero
  bool accumulate = false;      // C += instead of C =
  bool relu = false;            // max(C, 0) at the end
  int last_width = kLanes;      // valid columns of the last block of C, for weight gradients
};

// One block of LSTM gates: units in the order input, forget, cell, output (PyTorch), [4 * units][16].
struct LstmCell {
  int units = 0;
  float* gates = nullptr;                  // in: sums; out: activations. Backward, out: gradient of the sums
  const float* previous_cell = nullptr;    // [units][16]; null is zero
  float* cell = nullptr;                   // [units][16]; may be previous_cell in the forward direction
  float* cell_tanh = nullptr;              // [units][16]
  float* hidden = nullptr;                 // [units][16], forward output
  const float* hidden_gradient = nullptr;  // [units][16], backward
  float* cell_gradient = nullptr;  // [units][16], backward: in for this step, out for the previous one
};

// One block of single-query attention in the form that needs no keys or values (see attention.h).
struct AttentionBlock {
  int keys = 0;  // that the query may attend to
  int units = 0;
  float scale = 1.0f;
  const float* hidden = nullptr;    // [keys][units][16]
  const float* absent = nullptr;    // [keys][16], 1 where masked
  const float* query = nullptr;     // [units][16]
  const float* key_bias = nullptr;  // [units], broadcast
  const float* folded = nullptr;    // [units][16], u = W_k^T q
  float* weights = nullptr;         // [keys][16], softmax without the zero slot's share
  float* context = nullptr;         // [units][16], sum of weights * hidden
  float* total = nullptr;           // [16], sum of weights
  // Backward only.
  const float* context_gradient = nullptr;  // [units][16]
  const float* total_gradient = nullptr;    // [16]
  float* hidden_gradient = nullptr;         // [keys][units][16], written
  float* folded_gradient = nullptr;         // [units][16], written
  float* bias_score_gradient = nullptr;     // [16], of q . b_k, written
};

// One pass over a range of a flat parameter vector: sum the threads' gradients in order, Adam (Kingma and Ba
// 2015, in PyTorch's arrangement), the target's Polyak step, the running average. Gradients are zeroed for
// the next update.
struct AdamRange {
  size_t count = 0;  // a multiple of 16
  float* parameters = nullptr;
  float* first_moment = nullptr;
  float* second_moment = nullptr;
  float* const* gradients = nullptr;  // [threads], already at the range
  int threads = 1;
  float step_size = 0.0f;                // learning rate / (1 - beta1^t)
  float inverse_root_correction = 1.0f;  // 1 / sqrt(1 - beta2^t)
  float beta1 = 0.9f;
  float beta2 = 0.999f;
  float epsilon = 1e-8f;
  float* target = nullptr;  // null: none
  float tau = 0.0f;
};

struct LaneKernels {
  void (*multiply)(const Product&);
  // [features][16] -> [16][row_stride]; row_stride is at least features rounded up to 16, the rest of a row
  // is zeroed.
  void (*to_rows)(const float* lanes, int features, float* rows, ptrdiff_t row_stride);
  // [16][row_stride], unaligned, -> [features][16]; reads `count` rows, the other samples become zero.
  void (*to_lanes)(const float* rows, ptrdiff_t row_stride, int count, int features, float* lanes);
  void (*lstm_forward)(const LstmCell&);
  void (*lstm_backward)(const LstmCell&);
  void (*attention_forward)(const AttentionBlock&);
  void (*attention_backward)(const AttentionBlock&);
  // gradient = 0 where output is not positive; `count` a multiple of 16.
  void (*relu_backward)(const float* output, float* gradient, size_t count);
  // sums[i] += sum over blocks and samples of gradient[block][i][.]; sums [features].
  void (*sum_samples)(const float* gradient, ptrdiff_t block_stride, int blocks, int features, float* sums);
  // Over the features of each sample of one block; normalized may be input. inverse_deviation [16].
  void (*layer_norm_forward)(const float* input, int features, float* normalized, float* inverse_deviation);
  // gradient [features][16] in place.
  void (*layer_norm_backward)(const float* normalized, const float* inverse_deviation, int features,
                              float* gradient);
  // output = max(input, 0).
  void (*relu)(const float* input, float* output, size_t count);
  // False when a parameter is no longer finite.
  bool (*adam)(const AdamRange&);
  // average += (1 - decay) * (parameters - average).
  void (*average)(const float* parameters, float* average, size_t count, float decay);
};

// The kernels for one instruction set; asking for one this processor lacks is a programmer's mistake.
const LaneKernels& LaneKernelsFor(Isa isa);

}  // namespace dadrl::nn
