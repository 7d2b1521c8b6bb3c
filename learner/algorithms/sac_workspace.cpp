#include "learner/algorithms/sac_workspace.h"

namespace dadrl {
namespace {

SacWorkspace::Critic TakeCritic(nn::Arena& arena, const Mlp& head, int blocks) {
  SacWorkspace::Critic critic;
  critic.head = MlpActivations(arena, head, blocks);
  critic.value = nn::TakeLanes(arena, 1, blocks);
  critic.value_gradient = nn::TakeLanes(arena, 1, blocks);
  critic.input_gradient = nn::TakeLanes(arena, head.hidden1.inputs - kActionSize, blocks);
  critic.action_gradient = nn::TakeLanes(arena, kActionSize, blocks);
  return critic;
}

}  // namespace

SacWorkspace::SacWorkspace(nn::Arena& arena, const PolicyNetwork& policy, const CriticNetwork& critic,
                           const DrivingShape& spec, int blocks, int views)
    : now(arena, spec, blocks),
      next(arena, spec, blocks),
      kept(arena, critic.encoder, blocks, true),
      passing(arena, critic.encoder, blocks, false),
      encoder_scratch(arena, critic.encoder, blocks),
      policy_features(nn::TakeLanes(arena, policy.encoder.features(), blocks)),
      policy_feature_gradient(nn::TakeLanes(arena, policy.encoder.features(), blocks)),
      policy_output(nn::TakeLanes(arena, 2 * kActionSize, blocks)),
      policy_output_gradient(nn::TakeLanes(arena, 2 * kActionSize, blocks)),
      policy_head(arena, policy.head, blocks),
      policy_scratch(arena, policy.head, blocks),
      critic_input(nn::TakeLanes(arena, critic.critic1.hidden1.inputs, blocks)),
      target_input(nn::TakeLanes(arena, critic.critic1.hidden1.inputs, blocks)),
      critic1(TakeCritic(arena, critic.critic1, blocks)),
      critic2(TakeCritic(arena, critic.critic2, blocks)),
      critic_scratch(arena, critic.critic1, blocks),
      policy_gradient(arena.Allocate(policy.layout.size())) {
  for (int view = 0; view < views; ++view) critic_gradients.push_back(arena.Allocate(critic.layout.size()));
  const size_t capacity = static_cast<size_t>(blocks) * nn::kLanes;
  if (views > 1) shifted.resize(capacity * DrivingShape::kContextBytes);
  actions.dimensions.resize(capacity * kActionSize);
  actions.log_probability.resize(capacity);
  targets.resize(capacity);
}

}  // namespace dadrl
