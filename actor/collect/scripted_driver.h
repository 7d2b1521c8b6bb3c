// A driver of its own in an actor: experience to learn from that no learner's policy made.
#pragma once

#include <memory>

#include "actor/environment.h"
#include "actor/policies/driving_policy.h"
#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// Takes a driver's decisions as a policy's actions: a decision is held for task.decision_interval, whatever
// the driver asked for, and speeds beyond task.max_speed_mps are that. Not thread safe.
class ScriptedDriver {
 public:
  // The one of `actor.policy`, a name or the path of a policy file; null for `learned`. Errors of MakePolicy;
  // kInvalidArgument, with key and both values, when a policy was trained on other observations or decisions.
  static Result<std::unique_ptr<ScriptedDriver>> Make(const Config& config);

  // After the environment's Reset(seed).
  void BeginEpisode(uint64_t seed) { policy_->BeginEpisode(seed); }
  // For the scene that `environment` is in, which must be one of driving.
  Action Act(const Environment& environment);

 private:
  ScriptedDriver(std::unique_ptr<DrivingPolicy> policy, double max_speed_mps)
      : policy_(std::move(policy)), max_speed_mps_(max_speed_mps) {}

  std::unique_ptr<DrivingPolicy> policy_;
  double max_speed_mps_;
};

}  // namespace dadrl
