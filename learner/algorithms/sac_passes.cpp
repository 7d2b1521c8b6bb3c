// What each training thread does in an update of SAC.
#include <algorithm>
#include <cmath>

#include "learner/algorithms/plane_shift.h"
#include "learner/algorithms/sac.h"
#include "learner/algorithms/sac_losses.h"

namespace dadrl {

using nn::kLanes;
using nn::LaneSpan;

namespace {

void CriticsForward(const nn::LaneKernels& kernels, const CriticNetwork& critic, const float* parameters,
                    LaneSpan input, int blocks, SacWorkspace& workspace) {
  MlpForward(kernels, critic.critic1, parameters, input, blocks, workspace.critic1.head,
             workspace.critic1.value);
  MlpForward(kernels, critic.critic2, parameters, input, blocks, workspace.critic2.head,
             workspace.critic2.value);
}

// The part of `view` of what was drawn for all of them, `count` numbers each; nothing where there is one
// view.
std::span<const float> OfView(const std::vector<float>& draws, BatchView view, size_t count) {
  if (view.count == 1) return {};
  return std::span(draws).subspan(static_cast<size_t>(view.index) * count, count);
}

// sum += other, [blocks][features][16].
void Add(LaneSpan sum, LaneSpan other, int features, int blocks) {
  for (int b = 0; b < blocks; ++b) {
    float* to = sum.block(b);
    const float* from = other.block(b);
    for (int i = 0; i < features * kLanes; ++i) to[i] += from[i];
  }
}

}  // namespace

void Sac::PackShare(const Transitions& batch, SacWorkspace& workspace, int member) {
  const int threads = team_.size();
  const int blocks = (batch.size() + kLanes - 1) / kLanes;
  const int first = blocks * member / threads;
  const int count = blocks * (member + 1) / threads - first;
  workspace.first_sample = first * kLanes;
  workspace.samples = std::clamp(batch.size() - workspace.first_sample, 0, count * kLanes);
  workspace.sums = SacSums{};
  workspace.finite = true;
  workspace.now.blocks = count;
  workspace.next.blocks = count;
  workspace.now.Pack(kernels_, batch.observation, nullptr, first);
  workspace.next.Pack(kernels_, batch.next_observation, nullptr, first);
}

const uint8_t* Sac::PlanesOf(const uint8_t* context, std::span<const float> shifts, BatchView view,
                             SacWorkspace& workspace) const {
  const auto planes = [&](int sample) { return context + ptrdiff_t{sample} * DrivingShape::kContextBytes; };
  if (view.count == 1) return planes(workspace.first_sample);
  uint8_t* out = workspace.shifted.data();
  for (int i = workspace.first_sample; i < workspace.first_sample + workspace.samples; ++i) {
    const float* draw = &shifts[static_cast<size_t>(i) * 2];
    ShiftPlanes({planes(i), DrivingShape::kContextBytes},
                ShiftOf(draw[0], draw[1], config_.algorithm.shift_pixels), out);
    out += DrivingShape::kContextBytes;
  }
  return workspace.shifted.data();
}

void Sac::TargetPass(const Transitions& batch, SacWorkspace& workspace, BatchView view) {
  const int blocks = workspace.next.blocks;
  const int features = critic_.encoder.features();
  const size_t draws = static_cast<size_t>(batch.size()) * kActionSize;
  const size_t first_draw = static_cast<size_t>(view.index) * draws;
  workspace.next.context_planes = PlanesOf(next_context_, OfView(next_shifts_, view, draws), view, workspace);
  EncoderForward(kernels_, policy_.encoder, policy_parameters_.data(), workspace.next, workspace.passing,
                 workspace.policy_features);
  MlpForward(kernels_, policy_.head, policy_parameters_.data(), workspace.policy_features, blocks,
             workspace.policy_head, workspace.policy_output);
  SampleActions(workspace, limits_, std::span(next_noise_).subspan(first_draw, draws), workspace.target_input,
                features);
  EncoderForward(kernels_, critic_.encoder, target_parameters_.data(), workspace.next, workspace.passing,
                 workspace.target_input);
  CriticsForward(kernels_, critic_, target_parameters_.data(), workspace.target_input, blocks, workspace);
  ComputeTargets(workspace, batch, view, alpha_);
}

void Sac::CriticPass(const Transitions& batch, SacWorkspace& workspace, BatchView view) {
  const int blocks = workspace.now.blocks;
  const int features = critic_.encoder.features();
  const float* parameters = critic_parameters_.data();
  float* const gradient = workspace.critic_gradients[static_cast<size_t>(view.index)];
  const size_t draws = static_cast<size_t>(batch.size()) * kActionSize;
  workspace.now.context_planes = PlanesOf(now_context_, OfView(now_shifts_, view, draws), view, workspace);
  const float* action = batch.action.data() + ptrdiff_t{workspace.first_sample} * kActionSize;
  for (int i = 0; i < workspace.samples; ++i) {
    for (int d = 0; d < kActionSize; ++d) {
      workspace.critic_input.block(i / kLanes)[(features + d) * kLanes + i % kLanes] = *action++;
    }
  }
  EncoderForward(kernels_, critic_.encoder, parameters, workspace.now, workspace.kept,
                 workspace.critic_input);
  CriticsForward(kernels_, critic_, parameters, workspace.critic_input, blocks, workspace);
  CriticLoss(workspace, batch, view, td_error_);
  for (const auto& [mlp, critic] :
       {std::pair(&critic_.critic1, &workspace.critic1), std::pair(&critic_.critic2, &workspace.critic2)}) {
    MlpBackward(kernels_, *mlp, parameters, workspace.critic_input, blocks, critic->head,
                critic->value_gradient,
                {.parameters = gradient, .input = critic->input_gradient, .input_count = features},
                workspace.critic_scratch);
  }
  Add(workspace.critic1.input_gradient, workspace.critic2.input_gradient, features, blocks);
  EncoderBackward(kernels_, critic_.encoder, parameters, gradient, workspace.now, workspace.kept,
                  workspace.critic_input, workspace.critic1.input_gradient, workspace.encoder_scratch);
}

void Sac::ActorPass(const Transitions& batch, SacWorkspace& workspace) {
  const int blocks = workspace.now.blocks;
  const int features = critic_.encoder.features();
  const float* policy_parameters = policy_parameters_.data();
  const float* critic_parameters = critic_parameters_.data();
  // Without views the critic pass's features, from before the critic's step, serve the shared encoder.
  workspace.now.context_planes = PlanesOf(now_context_, {}, {}, workspace);
  LaneSpan policy_features = workspace.critic_input;
  if (!shared()) {
    policy_features = workspace.policy_features;
    EncoderForward(kernels_, policy_.encoder, policy_parameters, workspace.now, workspace.kept,
                   policy_features);
  }
  if (!shared() || views() > 1) {
    EncoderForward(kernels_, critic_.encoder, critic_parameters, workspace.now, workspace.passing,
                   workspace.critic_input);
  }
  MlpForward(kernels_, policy_.head, policy_parameters, policy_features, blocks, workspace.policy_head,
             workspace.policy_output);
  SampleActions(workspace, limits_, now_noise_, workspace.critic_input, features);
  CriticsForward(kernels_, critic_, critic_parameters, workspace.critic_input, blocks, workspace);
  ActorValueGradient(workspace, batch.size(), alpha_);
  for (const auto& [mlp, critic] :
       {std::pair(&critic_.critic1, &workspace.critic1), std::pair(&critic_.critic2, &workspace.critic2)}) {
    MlpBackward(kernels_, *mlp, critic_parameters, workspace.critic_input, blocks, critic->head,
                critic->value_gradient,
                {.input = critic->action_gradient, .first_input = features, .input_count = kActionSize},
                workspace.critic_scratch);
  }
  ActorOutputGradient(workspace, batch.size(), alpha_, now_noise_);
  MlpGradients wanted;
  wanted.parameters = workspace.policy_gradient;
  if (!shared()) {
    wanted.input = workspace.policy_feature_gradient;
    wanted.input_count = features;
  }
  MlpBackward(kernels_, policy_.head, policy_parameters, policy_features, blocks, workspace.policy_head,
              workspace.policy_output_gradient, wanted, workspace.policy_scratch);
  if (shared()) return;
  EncoderBackward(kernels_, policy_.encoder, policy_parameters, workspace.policy_gradient, workspace.now,
                  workspace.kept, policy_features, workspace.policy_feature_gradient,
                  workspace.encoder_scratch);
}

void Sac::UpdateShare(const Transitions& batch, int member) {
  SacWorkspace& workspace = workspaces_.data()[member];
  PackShare(batch, workspace, member);
  if (workspace.samples > 0) {
    for (int view = 0; view < views(); ++view) TargetPass(batch, workspace, {view, views()});
    for (int view = 0; view < views(); ++view) CriticPass(batch, workspace, {view, views()});
  }
  team_.Barrier();
  // Every thread sees the same sums and so takes the same way out; nothing has been stepped yet.
  const SacSums critic = TotalSums();
  if (!std::isfinite(critic.weighted_squares1 + critic.weighted_squares2)) return;
  StepCritic(member);
  team_.Barrier();
  if (!AllStepsFinite()) return;
  if (workspace.samples > 0) ActorPass(batch, workspace);
  team_.Barrier();
  if (!std::isfinite(TotalSums().actor)) return;
  StepPolicy(member);
}

void Sac::StepCritic(int member) {
  const nn::Range share = nn::ShareOf({0, critic_.layout.size()}, member, team_.size());
  workspaces_.data()[member].finite = nn::ApplyAdam(
      kernels_,
      {.learning_rate = config_.algorithm.critic_learning_rate, .epsilon = config_.algorithm.adam_epsilon},
      {.range = share,
       .parameters = critic_parameters_.data() + share.first,
       .target = target_parameters_.data() + share.first,
       .tau = config_.algorithm.tau,
       .moments = &critic_moments_,
       .gradients = critic_gradients_,
       .step = updates_ + 1});
  if (!shared()) return;
  // The policy's encoder is the critic's: both layouts begin with it.
  const size_t end = std::min(share.first + share.count, policy_.encoder_range.count);
  if (share.first < end) {
    std::copy(critic_parameters_.data() + share.first, critic_parameters_.data() + end,
              policy_parameters_.data() + share.first);
  }
}

void Sac::StepPolicy(int member) {
  const nn::Range trained = shared() ? policy_.head_range : nn::Range{0, policy_.layout.size()};
  const nn::Range share = nn::ShareOf(trained, member, team_.size());
  workspaces_.data()[member].finite = nn::ApplyAdam(
      kernels_,
      {.learning_rate = config_.algorithm.actor_learning_rate, .epsilon = config_.algorithm.adam_epsilon},
      {.range = share,
       .parameters = policy_parameters_.data() + share.first,
       .moments = &policy_moments_,
       .gradients = policy_gradients_,
       .step = updates_ + 1});
  // Early on the average is short, or the random start would linger in it for 1 / (1 - decay) updates.
  const double count = updates_;
  const double decay = std::min(config_.algorithm.average_decay, (1.0 + count) / (10.0 + count));
  team_.Barrier();
  const nn::Range averaged = nn::ShareOf({0, policy_.layout.size()}, member, team_.size());
  kernels_.average(policy_parameters_.data() + averaged.first, average_parameters_.data() + averaged.first,
                   averaged.count, static_cast<float>(decay));
}

}  // namespace dadrl
