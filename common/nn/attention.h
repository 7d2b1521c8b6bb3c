// Single-head attention with one query over some keys, with a zero slot and a mask (paper,
// section IV).
#pragma once

#include "common/nn/aligned_buffer.h"
#include "common/nn/linear.h"

namespace dadrl::nn {

// out = W_o (sum_v a_v (W_v h_v + b_v)) + b_o, a = softmax([q . (W_k h_v + b_k) / sqrt(units), 0]), q = W_q e
// + b_q. The last slot is a key and a value of zeros that is never masked, so that attention to nothing is
// defined. With one query the keys and values need not be formed: q . W_k h = (W_k^T q) . h and sum a W_v h =
// W_v (sum a h), four products of units x units a sample instead of two a key and two more.
struct Attention {
  int units = 0;
  int keys = 0;
  Linear query;
  Linear key;
  Linear value;
  Linear output;

  // Adds "<prefix>.query.weight" and so on.
  static Attention Add(ParamLayout& layout, const std::string& prefix, int units, int keys);
};

// For one batch, in an arena; the backward pass reads them.
struct AttentionActivations {
  AttentionActivations() = default;
  AttentionActivations(Arena& arena, const Attention& attention, int blocks);

  LaneSpan query;    // [blocks][units][16]
  LaneSpan folded;   // W_k^T q
  LaneSpan context;  // sum a h
  LaneSpan value;    // W_v context + total b_v
  LaneSpan weights;  // a, [blocks][keys][16]
  LaneSpan total;    // sum a, [blocks][1][16]
};

struct AttentionScratch {
  AttentionScratch() = default;
  AttentionScratch(Arena& arena, const Attention& attention, int blocks);

  LaneSpan query_gradient;
  LaneSpan folded_gradient;
  LaneSpan context_gradient;
  LaneSpan value_gradient;
  LaneSpan total_gradient;
  LaneSpan bias_score_gradient;
  float* rows = nullptr;
};

// hidden [blocks][1 + keys][units][16], the query's first; absent [blocks][keys][16], 1 where masked.
// sum [blocks][units][16] = the query's + out, the residual.
void AttentionForward(const LaneKernels& kernels, const Attention& attention, const float* parameters,
                      LaneSpan hidden, LaneSpan absent, int blocks, const AttentionActivations& activations,
                      LaneSpan sum);

// gradients += from sum_gradient; hidden_gradient [blocks][1 + keys][units][16] is written.
void AttentionBackward(const LaneKernels& kernels, const Attention& attention, const float* parameters,
                       float* gradients, LaneSpan hidden, int blocks, const AttentionActivations& activations,
                       LaneSpan sum_gradient, LaneSpan hidden_gradient, const AttentionScratch& scratch);

}  // namespace dadrl::nn
