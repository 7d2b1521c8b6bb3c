// A trained policy as a driver.
#pragma once

#include <memory>
#include <utility>

#include "actor/policies/driving_policy.h"
#include "common/model/policy_model.h"

namespace dadrl {

// The likeliest action of the policy, held for the decision interval it was trained with.
class LearnedPolicy final : public DrivingPolicy {
 public:
  // `policy` has its parameters loaded; the environment's configuration is the one it was trained with.
  explicit LearnedPolicy(std::unique_ptr<PolicyModel> policy) : policy_(std::move(policy)) {}
  void BeginEpisode(uint64_t) override { policy_->BeginEpisode(); }
  Decision Decide(const DrivingEnvironment& environment) override {
    const TaskConfig& task = environment.config().task;
    const Action action = policy_->Act(environment.observation(), nullptr);
    return {CommandOf(action, task.max_speed_mps), task.decision_interval};
  }
  std::span<const float> attention() const override { return policy_->last().attention; }

 private:
  std::unique_ptr<PolicyModel> policy_;
};

}  // namespace dadrl
