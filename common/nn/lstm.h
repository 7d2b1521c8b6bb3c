// A single-layer LSTM over short sequences from a zero state; only its last hidden state is used (paper,
// section IV).
#pragma once

#include "common/nn/aligned_buffer.h"
#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/param_layout.h"

namespace dadrl::nn {

// weight_ih [4 units][inputs], weight_hh [4 units][units], bias [4 units]; gates in PyTorch's order: input,
// forget, cell, output. One bias where PyTorch has two: only their sum acts, and both would get the same
// gradient.
struct Lstm {
  int inputs = 0;
  int units = 0;
  int steps = 0;
  size_t weight_ih = 0;
  size_t weight_hh = 0;
  size_t bias = 0;

  // Adds "<prefix>.weight_ih", ".weight_hh" and ".bias", uniform within 1 / sqrt(units) as in PyTorch.
  static Lstm Add(ParamLayout& layout, const std::string& prefix, int inputs, int units, int steps);
};

// What the backward pass needs, in an arena. With `keep` every step of every block is kept; without, two
// blocks at a time share one step's memory, which stays in the first-level cache.
struct LstmActivations {
  LstmActivations() = default;
  LstmActivations(Arena& arena, const Lstm& lstm, int blocks, bool keep);

  bool keep = false;
  float* gates = nullptr;
  float* cell = nullptr;
  float* cell_tanh = nullptr;
  float* hidden = nullptr;
};

// Scratch of the backward pass.
struct LstmScratch {
  LstmScratch() = default;
  LstmScratch(Arena& arena, const Lstm& lstm);

  float* hidden_gradient = nullptr;
  float* cell_gradient = nullptr;
  float* joined = nullptr;       // one step of [hidden, input, 1] in lanes
  float* rows = nullptr;         // all steps of it, one row a sample
  float* weight_sums = nullptr;  // gradient of [weight_hh, weight_ih, bias], side by side
};

// sequences [blocks][steps][inputs][16]; last_hidden [blocks][units][16]. A block is sixteen sequences, of
// whatever samples: all sequences of a batch go through one product a step.
void LstmForward(const LaneKernels& kernels, const Lstm& lstm, const float* parameters,
                 const float* sequences, int blocks, const LstmActivations& activations, float* last_hidden);

// gradients += from last_hidden_gradient [blocks][units][16]; none for the input. Consumes the (kept)
// activations.
void LstmBackward(const LaneKernels& kernels, const Lstm& lstm, const float* parameters, float* gradients,
                  const float* sequences, int blocks, const LstmActivations& activations,
                  const float* last_hidden_gradient, const LstmScratch& scratch);

}  // namespace dadrl::nn
