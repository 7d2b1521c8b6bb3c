#include "learner/algorithms/sac_losses.h"

#include <algorithm>
#include <cmath>

namespace dadrl {

using nn::kLanes;
using nn::LaneSpan;

namespace {

// Feature `row` of sample `i` of the share.
float& At(LaneSpan span, int row, int i) { return span.block(i / kLanes)[row * kLanes + i % kLanes]; }

size_t Index(int i) { return static_cast<size_t>(i); }

void Clear(LaneSpan span, int features, int samples) {
  for (int b = 0; b * kLanes < samples; ++b) std::fill_n(span.block(b), features * kLanes, 0.0f);
}

// NaN in either is NaN in the result, unlike std::min.
double Smaller(float a, float b) { return a <= b || std::isnan(a) ? a : b; }

// `mean` is complete after the last view.
void AddToMean(double value, BatchView view, float& mean) {
  const double before = view.index == 0 ? 0.0 : mean;
  mean = before + value / view.count;
}

}  // namespace

void SampleActions(SacWorkspace& workspace, const nn::GaussianLimits& limits, std::span<const float> noise,
                   LaneSpan critic_input, int features) {
  ActionSamples& actions = workspace.actions;
  for (int i = 0; i < workspace.samples; ++i) {
    double log_probability = 0.0;
    for (int d = 0; d < kActionSize; ++d) {
      const nn::SquashedSample sample = nn::SampleSquashed(
          At(workspace.policy_output, d, i), At(workspace.policy_output, kActionSize + d, i),
          noise[Index((workspace.first_sample + i) * kActionSize + d)], limits);
      actions.dimensions[Index(i * kActionSize + d)] = sample;
      log_probability += sample.log_probability;
      At(critic_input, features + d, i) = sample.action;
    }
    actions.log_probability[Index(i)] = log_probability;
  }
}

void ComputeTargets(SacWorkspace& workspace, const Transitions& batch, BatchView view, double alpha) {
  for (int i = 0; i < workspace.samples; ++i) {
    const size_t sample = Index(workspace.first_sample + i);
    const double value = Smaller(At(workspace.critic1.value, 0, i), At(workspace.critic2.value, 0, i)) -
                         alpha * workspace.actions.log_probability[Index(i)];
    const double target = batch.reward[sample] + batch.discount[sample] * value;
    AddToMean(target, view, workspace.targets[Index(i)]);
  }
}

void CriticLoss(SacWorkspace& workspace, const Transitions& batch, BatchView view,
                std::span<float> td_error) {
  Clear(workspace.critic1.value_gradient, 1, workspace.samples);
  Clear(workspace.critic2.value_gradient, 1, workspace.samples);
  const double scale = 2.0 / batch.size();
  const double share = 1.0 / view.count;
  SacSums& sums = workspace.sums;
  for (int i = 0; i < workspace.samples; ++i) {
    const size_t sample = Index(workspace.first_sample + i);
    const double weight = batch.weight[sample];
    const double target = workspace.targets[Index(i)];
    const double error1 = At(workspace.critic1.value, 0, i) - target;
    const double error2 = At(workspace.critic2.value, 0, i) - target;
    At(workspace.critic1.value_gradient, 0, i) = scale * weight * error1;
    At(workspace.critic2.value_gradient, 0, i) = scale * weight * error2;
    sums.weighted_squares1 += weight * error1 * error1;
    sums.weighted_squares2 += weight * error2 * error2;
    sums.q += share * (target + 0.5 * (error1 + error2));
    sums.target += share * target;
    AddToMean(std::abs(0.5 * (error1 + error2)), view, td_error[sample]);
  }
}

void ActorValueGradient(SacWorkspace& workspace, int batch_size, double alpha) {
  Clear(workspace.critic1.value_gradient, 1, workspace.samples);
  Clear(workspace.critic2.value_gradient, 1, workspace.samples);
  const float gradient = -1.0f / batch_size;
  for (int i = 0; i < workspace.samples; ++i) {
    const float value1 = At(workspace.critic1.value, 0, i);
    const float value2 = At(workspace.critic2.value, 0, i);
    At(value1 <= value2 ? workspace.critic1.value_gradient : workspace.critic2.value_gradient, 0, i) =
        gradient;
    const double log_probability = workspace.actions.log_probability[Index(i)];
    workspace.sums.actor += alpha * log_probability - Smaller(value1, value2);
    workspace.sums.log_probability += log_probability;
  }
}

void ActorOutputGradient(SacWorkspace& workspace, int batch_size, double alpha,
                         std::span<const float> noise) {
  Clear(workspace.policy_output_gradient, 2 * kActionSize, workspace.samples);
  const double log_probability_gradient = alpha / batch_size;
  for (int i = 0; i < workspace.samples; ++i) {
    for (int d = 0; d < kActionSize; ++d) {
      const double action_gradient = double{At(workspace.critic1.action_gradient, d, i)} +
                                     double{At(workspace.critic2.action_gradient, d, i)};
      const nn::SquashedGradient gradient =
          nn::SquashedBackward(workspace.actions.dimensions[Index(i * kActionSize + d)],
                               noise[Index((workspace.first_sample + i) * kActionSize + d)], action_gradient,
                               log_probability_gradient);
      At(workspace.policy_output_gradient, d, i) = gradient.mean;
      At(workspace.policy_output_gradient, kActionSize + d, i) = gradient.log_std;
    }
  }
}

}  // namespace dadrl
