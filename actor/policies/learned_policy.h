// A trained policy as a driver.
#pragma once

#include "actor/policies/driving_policy.h"
#include "common/model/acting_policy.h"

namespace dadrl {

// The mode of the policy's distribution, held for the decision interval it was trained with.
class LearnedPolicy final : public DrivingPolicy {
 public:
  // `policy` has its parameters loaded; the environment's configuration is the one it was trained with.
  explicit LearnedPolicy(ActingPolicy policy) : policy_(std::move(policy)) {}
  Decision Decide(const DrivingEnvironment& environment) override {
    const TaskConfig& task = environment.config().task;
    const Action action = policy_.Act(environment.observation(), nullptr);
    return {CommandOf(action, task.max_speed_mps), task.decision_interval};
  }
  std::span<const float> attention() const override { return policy_.last().attention; }

 private:
  ActingPolicy policy_;
};

}  // namespace dadrl
