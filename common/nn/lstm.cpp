#include "common/nn/lstm.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dadrl::nn {
namespace {

// Blocks that go through all steps together: a register tile's worth.
constexpr int kChunk = 2;

ptrdiff_t Units(const Lstm& lstm) { return ptrdiff_t{lstm.units} * kLanes; }

// hidden, input, and a one whose weights are the bias, padded to whole vectors.
int JoinedRow(const Lstm& lstm) {
  const int features = lstm.units + lstm.inputs + 1;
  return RoundUp(features, kLanes);
}

// Where a step of a block lies in the activations.
struct Places {
  Places(const Lstm& lstm, const LstmActivations& activations)
      : all(activations),
        units(Units(lstm)),
        step(activations.keep ? units : 0),
        block(activations.keep ? units * lstm.steps : units) {}
  // Blocks that do not keep their activations take turns.
  ptrdiff_t At(int b, int t) const { return (all.keep ? b : b % kChunk) * block + t * step; }
  float* gates(int b, int t) const { return all.gates + 4 * At(b, t); }
  float* cell(int b, int t) const { return all.cell + At(b, t); }
  float* cell_tanh(int b, int t) const { return all.cell_tanh + At(b, t); }
  float* hidden(int b, int t) const { return all.hidden + At(b, t); }

  const LstmActivations& all;
  ptrdiff_t units;
  ptrdiff_t step;
  ptrdiff_t block;
};

void GateSums(const LaneKernels& kernels, const Lstm& lstm, const float* parameters, const float* sequences,
              const Places& at, int first, int count, int t) {
  const ptrdiff_t sequence = ptrdiff_t{lstm.steps} * lstm.inputs * kLanes;
  Product product{.rows = 4 * lstm.units,
                  .blocks = count,
                  .depth = lstm.inputs,
                  .a = parameters + lstm.weight_ih,
                  .a_row = lstm.inputs,
                  .a_depth = 1,
                  .b = sequences + first * sequence + ptrdiff_t{t} * lstm.inputs * kLanes,
                  .b_block = sequence,
                  .b_depth = kLanes,
                  .c = at.gates(first, t),
                  .c_block = 4 * at.block,
                  .c_row = kLanes,
                  .bias = parameters + lstm.bias};
  kernels.multiply(product);
  if (t == 0) return;  // the state starts at zero
  product.depth = lstm.units;
  product.a = parameters + lstm.weight_hh;
  product.a_row = lstm.units;
  product.b = at.hidden(first, t - 1);
  product.b_block = at.block;
  product.bias = nullptr;
  product.accumulate = true;
  kernels.multiply(product);
}

// Gradients of one block's gate sums (now in its gates) times its inputs, added to the joined weight
// gradient.
void JoinedWeightGradient(const LaneKernels& kernels, const Lstm& lstm, const float* sequence,
                          const Places& at, int block, const LstmScratch& scratch) {
  const ptrdiff_t inputs = ptrdiff_t{lstm.inputs} * kLanes;
  const int row = JoinedRow(lstm);
  for (int t = 0; t < lstm.steps; ++t) {
    if (t == 0) {
      std::fill_n(scratch.joined, at.units, 0.0f);
    } else {
      std::copy_n(at.hidden(block, t - 1), at.units, scratch.joined);
    }
    std::copy_n(sequence + t * inputs, inputs, scratch.joined + at.units);
    kernels.to_rows(scratch.joined, row, scratch.rows + ptrdiff_t{t} * row * kLanes, row);
  }
  kernels.multiply({.rows = 4 * lstm.units,
                    .blocks = row / kLanes,
                    .depth = kLanes,
                    .segments = lstm.steps,
                    .a = at.gates(block, 0),
                    .a_row = kLanes,
                    .a_depth = 1,
                    .a_segment = 4 * at.units,
                    .b = scratch.rows,
                    .b_block = kLanes,
                    .b_depth = row,
                    .b_segment = ptrdiff_t{row} * kLanes,
                    .c = scratch.weight_sums,
                    .c_block = kLanes,
                    .c_row = row,
                    .accumulate = true});
}

void SplitWeightGradient(const Lstm& lstm, const float* sums, float* gradients) {
  const int row = JoinedRow(lstm);
  float* const bias = gradients + lstm.bias;
  for (int gate = 0; gate < 4 * lstm.units; ++gate, sums += row) {
    float* hh = gradients + lstm.weight_hh + ptrdiff_t{gate} * lstm.units;
    for (int j = 0; j < lstm.units; ++j) hh[j] += sums[j];
    float* ih = gradients + lstm.weight_ih + ptrdiff_t{gate} * lstm.inputs;
    for (int j = 0; j < lstm.inputs; ++j) ih[j] += sums[lstm.units + j];
    bias[gate] += sums[lstm.units + lstm.inputs];
  }
}

}  // namespace

Lstm Lstm::Add(ParamLayout& layout, const std::string& prefix, int inputs, int units, int steps) {
  const float bound = 1.0f / std::sqrt(static_cast<float>(units));
  Lstm lstm{.inputs = inputs, .units = units, .steps = steps};
  lstm.weight_ih = layout.Add(prefix + ".weight_ih", {4 * units, inputs}, bound);
  lstm.weight_hh = layout.Add(prefix + ".weight_hh", {4 * units, units}, bound);
  lstm.bias = layout.Add(prefix + ".bias", {4 * units}, bound);
  return lstm;
}

LstmActivations::LstmActivations(Arena& arena, const Lstm& lstm, int blocks, bool keep_all) : keep(keep_all) {
  const ptrdiff_t count = keep ? blocks * lstm.steps : kChunk;
  const ptrdiff_t units = Units(lstm);
  gates = arena.Allocate(count * 4 * units);
  cell = arena.Allocate(count * units);
  cell_tanh = arena.Allocate(count * units);
  hidden = arena.Allocate(count * units);
}

LstmScratch::LstmScratch(Arena& arena, const Lstm& lstm) {
  const ptrdiff_t row = JoinedRow(lstm);
  const ptrdiff_t units = Units(lstm);
  hidden_gradient = arena.Allocate(kChunk * units);
  cell_gradient = arena.Allocate(kChunk * units);
  joined = arena.Allocate(row * kLanes);
  rows = arena.Allocate(lstm.steps * row * kLanes);
  weight_sums = arena.Allocate(4 * lstm.units * row);
}

void LstmForward(const LaneKernels& kernels, const Lstm& lstm, const float* parameters,
                 const float* sequences, int blocks, const LstmActivations& activations, float* last_hidden) {
  const Places at(lstm, activations);
  for (int first = 0; first < blocks; first += kChunk) {
    const int end = std::min(first + kChunk, blocks);
    for (int t = 0; t < lstm.steps; ++t) {
      GateSums(kernels, lstm, parameters, sequences, at, first, end - first, t);
      const bool last = t + 1 == lstm.steps;
      for (int b = first; b < end; ++b) {
        kernels.lstm_forward({.units = lstm.units,
                              .gates = at.gates(b, t),
                              .previous_cell = t == 0 ? nullptr : at.cell(b, t - 1),
                              .cell = at.cell(b, t),
                              .cell_tanh = at.cell_tanh(b, t),
                              .hidden = last ? last_hidden + b * at.units : at.hidden(b, t)});
      }
    }
  }
}

void LstmBackward(const LaneKernels& kernels, const Lstm& lstm, const float* parameters, float* gradients,
                  const float* sequences, int blocks, const LstmActivations& activations,
                  const float* last_hidden_gradient, const LstmScratch& scratch) {
  const Places at(lstm, activations);
  const ptrdiff_t sequence = ptrdiff_t{lstm.steps} * lstm.inputs * kLanes;
  const int row = JoinedRow(lstm);
  std::fill_n(scratch.weight_sums, 4 * lstm.units * row, 0.0f);
  const ptrdiff_t one = ptrdiff_t{lstm.units + lstm.inputs} * kLanes;
  std::fill(scratch.joined + one, scratch.joined + one + kLanes, 1.0f);
  for (int first = 0; first < blocks; first += kChunk) {
    const int end = std::min(first + kChunk, blocks);
    const ptrdiff_t chunk = (end - first) * at.units;
    std::copy_n(last_hidden_gradient + first * at.units, chunk, scratch.hidden_gradient);
    std::fill_n(scratch.cell_gradient, chunk, 0.0f);
    for (int t = lstm.steps - 1; t >= 0; --t) {
      for (int b = first; b < end; ++b) {
        kernels.lstm_backward({.units = lstm.units,
                               .gates = at.gates(b, t),
                               .previous_cell = t == 0 ? nullptr : at.cell(b, t - 1),
                               .cell_tanh = at.cell_tanh(b, t),
                               .hidden_gradient = scratch.hidden_gradient + (b - first) * at.units,
                               .cell_gradient = scratch.cell_gradient + (b - first) * at.units});
      }
      if (t == 0) break;
      kernels.multiply({.rows = lstm.units,
                        .blocks = end - first,
                        .depth = 4 * lstm.units,
                        .a = parameters + lstm.weight_hh,
                        .a_row = 1,
                        .a_depth = lstm.units,
                        .b = at.gates(first, t),
                        .b_block = 4 * at.block,
                        .b_depth = kLanes,
                        .c = scratch.hidden_gradient,
                        .c_block = at.units,
                        .c_row = kLanes});
    }
    for (int b = first; b < end; ++b) {
      JoinedWeightGradient(kernels, lstm, sequences + b * sequence, at, b, scratch);
    }
  }
  SplitWeightGradient(lstm, scratch.weight_sums, gradients);
}

}  // namespace dadrl::nn
