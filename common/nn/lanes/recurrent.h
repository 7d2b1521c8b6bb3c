// LSTM cells and single-query attention on one block. Internal to the kernel translation units.
#pragma once

#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/lanes/vector.h"

namespace dadrl::nn {
namespace {

void LstmForward(const LstmCell& s) {
  const ptrdiff_t gate = ptrdiff_t{s.units} * kLanes;
  for (ptrdiff_t j = 0; j < gate; j += kLanes) {
    const Lanes input = Sigmoid(Load(s.gates + j));
    const Lanes forget = Sigmoid(Load(s.gates + gate + j));
    const Lanes candidate = Tanh(Load(s.gates + 2 * gate + j));
    const Lanes output = Sigmoid(Load(s.gates + 3 * gate + j));
    Store(s.gates + j, input);
    Store(s.gates + gate + j, forget);
    Store(s.gates + 2 * gate + j, candidate);
    Store(s.gates + 3 * gate + j, output);
    Lanes cell = input * candidate;
    if (s.previous_cell != nullptr) cell += forget * Load(s.previous_cell + j);
    const Lanes squashed = Tanh(cell);
    Store(s.cell + j, cell);
    Store(s.cell_tanh + j, squashed);
    Store(s.hidden + j, output * squashed);
  }
}

void LstmBackward(const LstmCell& s) {
  const ptrdiff_t gate = ptrdiff_t{s.units} * kLanes;
  for (ptrdiff_t j = 0; j < gate; j += kLanes) {
    const Lanes input = Load(s.gates + j);
    const Lanes forget = Load(s.gates + gate + j);
    const Lanes candidate = Load(s.gates + 2 * gate + j);
    const Lanes output = Load(s.gates + 3 * gate + j);
    const Lanes squashed = Load(s.cell_tanh + j);
    const Lanes dh = Load(s.hidden_gradient + j);
    const Lanes dc = Load(s.cell_gradient + j) + dh * output * (1.0f - squashed * squashed);
    const Lanes before = s.previous_cell == nullptr ? Lanes{} : Load(s.previous_cell + j);
    Store(s.gates + j, dc * candidate * input * (1.0f - input));
    Store(s.gates + gate + j, dc * before * forget * (1.0f - forget));
    Store(s.gates + 2 * gate + j, dc * input * (1.0f - candidate * candidate));
    Store(s.gates + 3 * gate + j, dh * squashed * output * (1.0f - output));
    Store(s.cell_gradient + j, dc * forget);
  }
}

// Masked scores: far below any real one, yet finite, so that an all-absent row stays defined.
constexpr float kMaskedScore = -1e30f;

DADRL_INLINE Lanes Dot(const float* a, const float* b, int units) {
  Lanes sums[4] = {};
  for (int j = 0; j < units; ++j) sums[j & 3] += Load(a + j * kLanes) * Load(b + j * kLanes);
  return (sums[0] + sums[1]) + (sums[2] + sums[3]);
}

void AttentionForward(const AttentionBlock& s) {
  const ptrdiff_t stride = ptrdiff_t{s.units} * kLanes;
  Lanes bias = {};
  for (int j = 0; j < s.units; ++j) bias += Load(s.query + j * kLanes) * s.key_bias[j];
  Lanes highest = {};  // the zero slot's score
  for (int v = 0; v < s.keys; ++v) {
    Lanes score = (Dot(s.folded, s.hidden + v * stride, s.units) + bias) * s.scale;
    score = Load(s.absent + v * kLanes) > 0.5f ? Splat(kMaskedScore) : score;
    highest = score > highest ? score : highest;
    Store(s.weights + v * kLanes, score);
  }
  Lanes sum = Exp(-highest);
  for (int v = 0; v < s.keys; ++v) {
    const Lanes absent = Load(s.absent + v * kLanes);
    Lanes weight = Exp(Load(s.weights + v * kLanes) - highest);
    weight = absent > 0.5f ? Lanes{} : weight;
    sum += weight;
    Store(s.weights + v * kLanes, weight);
  }
  const Lanes inverse = 1.0f / sum;
  Lanes total = {};
  for (int v = 0; v < s.keys; ++v) {
    const Lanes weight = Load(s.weights + v * kLanes) * inverse;
    total += weight;
    Store(s.weights + v * kLanes, weight);
  }
  Store(s.total, total);
  for (int j = 0; j < s.units; ++j) {
    Lanes context = {};
    for (int v = 0; v < s.keys; ++v) {
      context += Load(s.weights + v * kLanes) * Load(s.hidden + v * stride + j * kLanes);
    }
    Store(s.context + j * kLanes, context);
  }
}

void AttentionBackward(const AttentionBlock& s) {
  const ptrdiff_t stride = ptrdiff_t{s.units} * kLanes;
  Lanes projected = {};  // sum of weight * its gradient; the zero slot's gradient is zero
  for (int v = 0; v < s.keys; ++v) {
    const Lanes g = Dot(s.context_gradient, s.hidden + v * stride, s.units) + Load(s.total_gradient);
    projected += g * Load(s.weights + v * kLanes);
    Store(s.hidden_gradient + v * stride, g);  // parked until the next loop
  }
  Lanes bias_gradient = {};
  for (int j = 0; j < s.units; ++j) Store(s.folded_gradient + j * kLanes, Lanes{});
  for (int v = 0; v < s.keys; ++v) {
    const Lanes weight = Load(s.weights + v * kLanes);
    const Lanes score = weight * (Load(s.hidden_gradient + v * stride) - projected) * s.scale;
    bias_gradient += score;
    for (int j = 0; j < s.units; ++j) {
      const ptrdiff_t at = v * stride + j * kLanes;
      Store(s.folded_gradient + j * kLanes,
            Load(s.folded_gradient + j * kLanes) + score * Load(s.hidden + at));
      Store(s.hidden_gradient + at,
            weight * Load(s.context_gradient + j * kLanes) + score * Load(s.folded + j * kLanes));
    }
  }
  Store(s.bias_score_gradient, bias_gradient);
}

}  // namespace
}  // namespace dadrl::nn
