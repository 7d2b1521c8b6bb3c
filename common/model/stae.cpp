#include "common/model/stae.h"

#include <cstring>

namespace dadrl {

using nn::kLanes;
using nn::LaneSpan;

namespace {

constexpr int kEgo = DrivingShape::kEgoFeatures;

int Sequences(const Stae& stae) { return 1 + stae.attention.keys; }

}  // namespace

Stae Stae::Add(nn::ParamLayout& layout, const std::string& prefix, const DrivingShape& spec) {
  Stae stae;
  stae.lstm = nn::Lstm::Add(layout, prefix + ".lstm", DrivingShape::kVehicleFeatures, kUnits, spec.history);
  stae.attention = nn::Attention::Add(layout, prefix + ".attention", kUnits, spec.vehicles);
  stae.output = nn::Linear::Add(layout, prefix + ".output", kEgo + kUnits, kFeatures);
  return stae;
}

StaeActivations::StaeActivations(nn::Arena& arena, const Stae& stae, int blocks, bool keep)
    : lstm(arena, stae.lstm, blocks * Sequences(stae), keep),
      hidden(nn::TakeLanes(arena, Sequences(stae) * Stae::kUnits, blocks)),
      attention(arena, stae.attention, blocks),
      joined(nn::TakeLanes(arena, kEgo + Stae::kUnits, blocks)),
      inverse_deviation(arena.Allocate(ptrdiff_t{blocks} * kLanes)) {}

StaeScratch::StaeScratch(nn::Arena& arena, const Stae& stae, int blocks)
    : sum_gradient(nn::TakeLanes(arena, Stae::kUnits, blocks)),
      hidden_gradient(nn::TakeLanes(arena, Sequences(stae) * Stae::kUnits, blocks)),
      attention(arena, stae.attention, blocks),
      lstm(arena, stae.lstm),
      rows(arena.Allocate(nn::WeightScratch(kEgo + Stae::kUnits, blocks))) {}

void StaeForward(const nn::LaneKernels& kernels, const Stae& stae, const float* parameters,
                 const LaneObservations& observations, const StaeActivations& activations,
                 LaneSpan features) {
  const int blocks = observations.blocks;
  nn::LstmForward(kernels, stae.lstm, parameters, observations.sequences, blocks * Sequences(stae),
                  activations.lstm, activations.hidden.data);
  const LaneSpan sum = activations.joined.From(kEgo);
  nn::AttentionForward(kernels, stae.attention, parameters, activations.hidden, observations.absent, blocks,
                       activations.attention, sum);
  for (int b = 0; b < blocks; ++b) {
    kernels.layer_norm_forward(sum.block(b), Stae::kUnits, sum.block(b),
                               activations.inverse_deviation + b * kLanes);
    std::memcpy(activations.joined.block(b), observations.ego_now().block(b), kEgo * kLanes * sizeof(float));
  }
  nn::LinearForward(kernels, stae.output, parameters, activations.joined, features, blocks, true);
}

void StaeBackward(const nn::LaneKernels& kernels, const Stae& stae, const float* parameters, float* gradients,
                  const LaneObservations& observations, const StaeActivations& activations,
                  LaneSpan feature_gradient, const StaeScratch& scratch) {
  const int blocks = observations.blocks;
  nn::LinearWeightGradient(kernels, stae.output, gradients, activations.joined, feature_gradient, blocks,
                           scratch.rows);
  nn::LinearInputGradient(kernels, stae.output, parameters, feature_gradient, scratch.sum_gradient, kEgo,
                          Stae::kUnits, blocks);
  for (int b = 0; b < blocks; ++b) {
    kernels.layer_norm_backward(activations.joined.From(kEgo).block(b),
                                activations.inverse_deviation + b * kLanes, Stae::kUnits,
                                scratch.sum_gradient.block(b));
  }
  nn::AttentionBackward(kernels, stae.attention, parameters, gradients, activations.hidden, blocks,
                        activations.attention, scratch.sum_gradient, scratch.hidden_gradient,
                        scratch.attention);
  nn::LstmBackward(kernels, stae.lstm, parameters, gradients, observations.sequences,
                   blocks * Sequences(stae), activations.lstm, scratch.hidden_gradient.data, scratch.lstm);
}

}  // namespace dadrl
