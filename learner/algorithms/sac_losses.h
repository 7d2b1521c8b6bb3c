// The losses of soft actor-critic (Haarnoja et al. 2018) and their gradients, on one thread's share of a
// batch.
#pragma once

#include <span>

#include "learner/algorithms/n_step.h"
#include "learner/algorithms/sac_workspace.h"

namespace dadrl {

// Samples an action for each row of workspace.policy_output, with noise [batch, 2], into workspace.actions
// and into the two action rows of `critic_input` [blocks][features + 2][16].
void SampleActions(SacWorkspace& workspace, const nn::GaussianLimits& limits, std::span<const float> noise,
                   nn::LaneSpan critic_input, int features);

// workspace.targets = reward + discount (min Q_target(s', a') - alpha log pi(a'|s')). The discount is
// gamma^k, or 0 at a termination, so n-step returns, truncation and termination need no cases here. Of
// several views it is the mean, complete after the last.
void ComputeTargets(SacWorkspace& workspace, const Transitions& batch, BatchView view, double alpha);

// Critic loss = sum over both critics of (1 / batch) sum of weight (Q - target)^2, without a factor one half.
// Fills both value gradients, the sums, and td_error [batch]. The losses of several views add up, the other
// sums and the errors are means over them, complete after the last.
void CriticLoss(SacWorkspace& workspace, const Transitions& batch, BatchView view, std::span<float> td_error);

// Actor loss = (1 / batch) sum of alpha log pi - min Q, not importance weighted. First half: the gradient
// with respect to the values, which goes to the smaller critic alone.
void ActorValueGradient(SacWorkspace& workspace, int batch_size, double alpha);
// Second half, after the critics' backward pass: the gradient with respect to workspace.policy_output.
void ActorOutputGradient(SacWorkspace& workspace, int batch_size, double alpha, std::span<const float> noise);

}  // namespace dadrl
