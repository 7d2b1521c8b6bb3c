// The sequential latent transformer (Liu et al. 2022): from what the encoder says of a step and from the
// action, what it will say of the next one. A training's help: nothing acts with it.
#pragma once

#include <span>

#include "common/nn/graph/tape.h"

namespace dadrl {

// Of `steps` steps: each latent with its action (Dense 64, ReLU), causal attention over the steps, one head;
// a projector (256, 128, ReLU each), which the latents behind each step go through too; a predictor, Dense
// 128. The prediction is compared with the projection of what came.
struct LatentPrediction {
  static constexpr int kUnits = 128;

  LatentPrediction(int latent_features, int steps);

  nn::ParamLayout layout;
  nn::Graph graph;
  nn::Value latents;     // differentiable input [steps, latent_features]
  nn::Value actions;     // input [steps, 2]
  nn::Value next;        // input [steps, latent_features]: behind each step
  nn::Value prediction;  // [steps, 128]
  nn::Value target;      // [steps, 128]
};

// The negative cosine of two vectors, and its gradient with respect to `prediction`, times `scale`. One
// without a length has no direction: 0, without a gradient.
double NegativeCosine(std::span<const float> prediction, std::span<const float> target, double scale,
                      std::span<float> gradient);

}  // namespace dadrl
