// The spatio-temporal attention encoder (paper, section IV): who is around, and who matters.
#pragma once

#include "common/model/lane_observations.h"
#include "common/nn/attention.h"
#include "common/nn/lstm.h"

namespace dadrl {

// One LSTM (7 -> 56) reads the history of the ego and of each vehicle, absent rows included as {1, 0, ...};
// the ego's last state attends to the vehicles', those whose newest row is absent masked; residual, layer
// norm without affine; with the ego's newest row, Linear(20 + 56 -> 128) and ReLU.
struct Stae {
  static constexpr int kUnits = 56;
  static constexpr int kFeatures = 128;

  static Stae Add(nn::ParamLayout& layout, const std::string& prefix, const DrivingShape& spec);

  nn::Lstm lstm;
  nn::Attention attention;
  nn::Linear output;
};

struct StaeActivations {
  StaeActivations() = default;
  StaeActivations(nn::Arena& arena, const Stae& stae, int blocks, bool keep);

  nn::LstmActivations lstm;
  nn::LaneSpan hidden;  // [blocks][1 + vehicles][56][16]
  nn::AttentionActivations attention;
  nn::LaneSpan joined;                 // [blocks][20 + 56][16]: the ego's newest row, the normalised sum
  float* inverse_deviation = nullptr;  // [blocks][16]
};

struct StaeScratch {
  StaeScratch() = default;
  StaeScratch(nn::Arena& arena, const Stae& stae, int blocks);

  nn::LaneSpan sum_gradient;
  nn::LaneSpan hidden_gradient;
  nn::AttentionScratch attention;
  nn::LstmScratch lstm;
  float* rows = nullptr;
};

// features [blocks][128][16].
void StaeForward(const nn::LaneKernels& kernels, const Stae& stae, const float* parameters,
                 const LaneObservations& observations, const StaeActivations& activations,
                 nn::LaneSpan features);

// gradients += from feature_gradient, which must already be zero where the feature is not positive. Consumes
// the (kept) activations.
void StaeBackward(const nn::LaneKernels& kernels, const Stae& stae, const float* parameters, float* gradients,
                  const LaneObservations& observations, const StaeActivations& activations,
                  nn::LaneSpan feature_gradient, const StaeScratch& scratch);

}  // namespace dadrl
