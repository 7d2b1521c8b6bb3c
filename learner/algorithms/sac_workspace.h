// The memory of one training thread of SAC: its share of the batch on its way through the networks.
#pragma once

#include <vector>

#include "common/model/networks.h"
#include "common/nn/squashed_gaussian.h"
#include "common/nn/thread_team.h"

namespace dadrl {

// Sums over a thread's samples, added up over threads in a fixed order.
struct SacSums {
  double weighted_squares1 = 0.0;  // of critic 1
  double weighted_squares2 = 0.0;
  double q = 0.0;  // mean of both critics
  double target = 0.0;
  double actor = 0.0;
  double log_probability = 0.0;
};

// An actor's draw at each sample of the share, for both action dimensions.
struct ActionSamples {
  std::vector<nn::SquashedSample> dimensions;  // [samples, 2]
  std::vector<double> log_probability;         // [samples]
};

// Which of a batch's views a pass is over.
struct BatchView {
  int index = 0;
  int count = 1;
};

// Laid out in an arena once; spans hold up to `blocks` blocks.
struct SacWorkspace {
  SacWorkspace(nn::Arena& arena, const PolicyNetwork& policy, const CriticNetwork& critic,
               const DrivingShape& spec, int blocks, int views);

  // The share of this update: samples [first, first + samples) of the batch; the rest of the last block is
  // padding.
  int first_sample = 0;
  int samples = 0;

  LaneObservations now;
  LaneObservations next;
  EncoderActivations kept;     // of the encoder that is being trained
  EncoderActivations passing;  // of encoders that are only read
  EncoderScratch encoder_scratch;

  nn::LaneSpan policy_features;          // [blocks][features][16]
  nn::LaneSpan policy_feature_gradient;  // the same
  nn::LaneSpan policy_output;            // [blocks][4][16]
  nn::LaneSpan policy_output_gradient;
  MlpActivations policy_head;
  MlpScratch policy_scratch;

  nn::LaneSpan critic_input;  // [blocks][features + 2][16]
  nn::LaneSpan target_input;
  struct Critic {
    MlpActivations head;
    nn::LaneSpan value;            // [blocks][1][16]
    nn::LaneSpan value_gradient;   // [blocks][1][16]
    nn::LaneSpan input_gradient;   // [blocks][features][16]
    nn::LaneSpan action_gradient;  // [blocks][2][16]
  };
  Critic critic1;
  Critic critic2;
  MlpScratch critic_scratch;

  float* policy_gradient = nullptr;      // this thread's, policy.layout
  std::vector<float*> critic_gradients;  // critic.layout, one a view

  std::vector<uint8_t> shifted;  // planes of the present view, [samples, 4096]; empty without views
  ActionSamples actions;
  std::vector<float> targets;  // [samples]
  SacSums sums;
  bool finite = true;  // the parameters this thread stepped
};

}  // namespace dadrl
