// A Gaussian pushed through tanh, from the encoder and a head (PolicyNetwork): tens of microseconds an
// action.
#pragma once

#include <memory>

#include "common/model/policy_model.h"

namespace dadrl {

// Samples tanh(mean + exp(log_std) * noise); the likeliest is tanh(mean). Agrees with the batched path to
// 1e-5. Remembers nothing of an episode. Says "mean" (before tanh) and "log_std" (clamped), each [2], and its
// attention, if it has a STAE; the rest of it to 1 is the zero slot's. kInvalidArgument when a driving column
// is missing.
Result<std::unique_ptr<PolicyModel>> MakeSquashedGaussianPolicy(const StepSpec& spec,
                                                                const ModelConfig& model);

}  // namespace dadrl
