// The decision transformer as a policy: it remembers the last decisions of an episode.
#pragma once

#include <memory>

#include "common/model/policy_model.h"

namespace dadrl {

// Deterministic: with or without noise the action is the network's, asked for the return of a success. What
// it remembers are the observations and actions of the last 19 decisions. kInvalidArgument when a driving
// column is missing.
Result<std::unique_ptr<PolicyModel>> MakeDecisionTransformerPolicy(const StepSpec& spec,
                                                                   const ModelConfig& model);

}  // namespace dadrl
