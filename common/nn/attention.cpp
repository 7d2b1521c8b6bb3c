#include "common/nn/attention.h"

#include <cmath>
#include <cstring>

namespace dadrl::nn {
namespace {

AttentionBlock BlockOf(const Attention& attention, const float* parameters, LaneSpan hidden,
                       const AttentionActivations& activations, int block) {
  return {.keys = attention.keys,
          .units = attention.units,
          .scale = 1.0f / std::sqrt(static_cast<float>(attention.units)),
          .hidden = hidden.From(attention.units).block(block),
          .query = activations.query.block(block),
          .key_bias = parameters + attention.key.bias,
          .folded = activations.folded.block(block),
          .weights = activations.weights.block(block),
          .context = activations.context.block(block),
          .total = activations.total.block(block)};
}

// product += b_v total: the value bias acts as often as there is attention on real keys.
Product RankOne(const float* column, LaneSpan scale, LaneSpan product, int rows, int blocks) {
  return {.rows = rows,
          .blocks = blocks,
          .depth = 1,
          .a = column,
          .a_row = 1,
          .b = scale.data,
          .b_block = scale.block_stride,
          .c = product.data,
          .c_block = product.block_stride,
          .c_row = kLanes,
          .accumulate = true};
}

// output = W^T input or W input, without bias.
Product Multiply(const float* weight, bool transposed, int units, LaneSpan input, LaneSpan output,
                 int blocks) {
  return {.rows = units,
          .blocks = blocks,
          .depth = units,
          .a = weight,
          .a_row = transposed ? 1 : units,
          .a_depth = transposed ? units : 1,
          .b = input.data,
          .b_block = input.block_stride,
          .b_depth = kLanes,
          .c = output.data,
          .c_block = output.block_stride,
          .c_row = kLanes};
}

}  // namespace

Attention Attention::Add(ParamLayout& layout, const std::string& prefix, int units, int keys) {
  Attention attention;
  attention.units = units;
  attention.keys = keys;
  attention.query = Linear::Add(layout, prefix + ".query", units, units);
  attention.key = Linear::Add(layout, prefix + ".key", units, units);
  attention.value = Linear::Add(layout, prefix + ".value", units, units);
  attention.output = Linear::Add(layout, prefix + ".output", units, units);
  return attention;
}

AttentionActivations::AttentionActivations(Arena& arena, const Attention& attention, int blocks)
    : query(TakeLanes(arena, attention.units, blocks)),
      folded(TakeLanes(arena, attention.units, blocks)),
      context(TakeLanes(arena, attention.units, blocks)),
      value(TakeLanes(arena, attention.units, blocks)),
      weights(TakeLanes(arena, attention.keys, blocks)),
      total(TakeLanes(arena, 1, blocks)) {}

AttentionScratch::AttentionScratch(Arena& arena, const Attention& attention, int blocks)
    : query_gradient(TakeLanes(arena, attention.units, blocks)),
      folded_gradient(TakeLanes(arena, attention.units, blocks)),
      context_gradient(TakeLanes(arena, attention.units, blocks)),
      value_gradient(TakeLanes(arena, attention.units, blocks)),
      total_gradient(TakeLanes(arena, 1, blocks)),
      bias_score_gradient(TakeLanes(arena, 1, blocks)),
      rows(arena.Allocate(WeightScratch(attention.units, blocks))) {}

void AttentionForward(const LaneKernels& kernels, const Attention& attention, const float* parameters,
                      LaneSpan hidden, LaneSpan absent, int blocks, const AttentionActivations& activations,
                      LaneSpan sum) {
  LinearForward(kernels, attention.query, parameters, hidden, activations.query, blocks, false);
  kernels.multiply(Multiply(parameters + attention.key.weight, true, attention.units, activations.query,
                            activations.folded, blocks));
  for (int block = 0; block < blocks; ++block) {
    AttentionBlock task = BlockOf(attention, parameters, hidden, activations, block);
    task.absent = absent.block(block);
    kernels.attention_forward(task);
  }
  kernels.multiply(Multiply(parameters + attention.value.weight, false, attention.units, activations.context,
                            activations.value, blocks));
  kernels.multiply(RankOne(parameters + attention.value.bias, activations.total, activations.value,
                           attention.units, blocks));
  const size_t block_bytes = static_cast<size_t>(attention.units) * kLanes * sizeof(float);
  for (int block = 0; block < blocks; ++block)
    std::memcpy(sum.block(block), hidden.block(block), block_bytes);
  Product output =
      Multiply(parameters + attention.output.weight, false, attention.units, activations.value, sum, blocks);
  output.bias = parameters + attention.output.bias;
  output.accumulate = true;
  kernels.multiply(output);
}

void AttentionBackward(const LaneKernels& kernels, const Attention& attention, const float* parameters,
                       float* gradients, LaneSpan hidden, int blocks, const AttentionActivations& activations,
                       LaneSpan sum_gradient, LaneSpan hidden_gradient, const AttentionScratch& scratch) {
  const int units = attention.units;
  LinearWeightGradient(kernels, attention.output, gradients, activations.value, sum_gradient, blocks,
                       scratch.rows);
  LinearInputGradient(kernels, attention.output, parameters, sum_gradient, scratch.value_gradient, 0, units,
                      blocks);

  OuterProductSum(kernels, scratch.value_gradient, units, activations.context, units, blocks,
                  gradients + attention.value.weight, scratch.rows);
  OuterProductSum(kernels, scratch.value_gradient, units, activations.total, 1, blocks,
                  gradients + attention.value.bias, scratch.rows);
  LinearInputGradient(kernels, attention.value, parameters, scratch.value_gradient, scratch.context_gradient,
                      0, units, blocks);
  kernels.multiply({.rows = 1,
                    .blocks = blocks,
                    .depth = units,
                    .a = parameters + attention.value.bias,
                    .a_depth = 1,
                    .b = scratch.value_gradient.data,
                    .b_block = scratch.value_gradient.block_stride,
                    .b_depth = kLanes,
                    .c = scratch.total_gradient.data,
                    .c_block = scratch.total_gradient.block_stride,
                    .c_row = kLanes});

  for (int block = 0; block < blocks; ++block) {
    AttentionBlock task = BlockOf(attention, parameters, hidden, activations, block);
    task.context_gradient = scratch.context_gradient.block(block);
    task.total_gradient = scratch.total_gradient.block(block);
    task.hidden_gradient = hidden_gradient.From(units).block(block);
    task.folded_gradient = scratch.folded_gradient.block(block);
    task.bias_score_gradient = scratch.bias_score_gradient.block(block);
    kernels.attention_backward(task);
  }

  // q acts through W_k^T q and through q . b_k.
  OuterProductSum(kernels, activations.query, units, scratch.folded_gradient, units, blocks,
                  gradients + attention.key.weight, scratch.rows);
  OuterProductSum(kernels, activations.query, units, scratch.bias_score_gradient, 1, blocks,
                  gradients + attention.key.bias, scratch.rows);
  // OuterProductSum sums q times the score's gradient over samples, as b_k's gradient wants.
  kernels.multiply(Multiply(parameters + attention.key.weight, false, units, scratch.folded_gradient,
                            scratch.query_gradient, blocks));
  kernels.multiply(RankOne(parameters + attention.key.bias, scratch.bias_score_gradient,
                           scratch.query_gradient, units, blocks));

  LinearWeightGradient(kernels, attention.query, gradients, hidden, scratch.query_gradient, blocks,
                       scratch.rows);
  LinearInputGradient(kernels, attention.query, parameters, scratch.query_gradient, hidden_gradient, 0, units,
                      blocks);
  for (int block = 0; block < blocks; ++block) {
    float* to = hidden_gradient.block(block);
    const float* from = sum_gradient.block(block);
    for (ptrdiff_t i = 0; i < ptrdiff_t{units} * kLanes; ++i) to[i] += from[i];
  }
}

}  // namespace dadrl::nn
