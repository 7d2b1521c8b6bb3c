#include "learner/algorithms/sac_workspace.h"

namespace dadrl {
namespace {

nn::LaneSpan Take(nn::Arena& arena, int features, int blocks) {
  return nn::Contiguous(
      arena.Allocate(static_cast<size_t>(features * nn::kLanes) * static_cast<size_t>(blocks)), features);
}

SacWorkspace::Critic TakeCritic(nn::Arena& arena, const Mlp& head, int blocks) {
  SacWorkspace::Critic critic;
  critic.head = MlpActivations(arena, head, blocks);
  critic.value = Take(arena, 1, blocks);
  critic.value_gradient = Take(arena, 1, blocks);
  critic.input_gradient = Take(arena, head.hidden1.inputs - kActionSize, blocks);
  critic.action_gradient = Take(arena, kActionSize, blocks);
  return critic;
}

}  // namespace

SacWorkspace::SacWorkspace(nn::Arena& arena, const PolicyNetwork& policy, const CriticNetwork& critic,
                           const ObservationSpec& spec, int blocks)
    : now(arena, spec, blocks),
      next(arena, spec, blocks),
      kept(arena, critic.encoder, blocks, true),
      passing(arena, critic.encoder, blocks, false),
      encoder_scratch(arena, critic.encoder, blocks),
      policy_features(Take(arena, policy.encoder.features(), blocks)),
      policy_feature_gradient(Take(arena, policy.encoder.features(), blocks)),
      policy_output(Take(arena, 2 * kActionSize, blocks)),
      policy_output_gradient(Take(arena, 2 * kActionSize, blocks)),
      policy_head(arena, policy.head, blocks),
      policy_scratch(arena, policy.head, blocks),
      critic_input(Take(arena, critic.critic1.hidden1.inputs, blocks)),
      target_input(Take(arena, critic.critic1.hidden1.inputs, blocks)),
      critic1(TakeCritic(arena, critic.critic1, blocks)),
      critic2(TakeCritic(arena, critic.critic2, blocks)),
      critic_scratch(arena, critic.critic1, blocks),
      policy_gradient(arena.Allocate(policy.layout.size())),
      critic_gradient(arena.Allocate(critic.layout.size())) {
  const size_t capacity = static_cast<size_t>(blocks) * nn::kLanes;
  actions.dimensions.resize(capacity * kActionSize);
  actions.log_probability.resize(capacity);
  targets.resize(capacity);
}

}  // namespace dadrl
