// Checks that involve more than one key; ranges of single keys are in config_schema.cpp, what a learning
// algorithm needs is checked by learner/algorithms/registry.h, where it is made.
#pragma once

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// A batch on its way to the learner is never longer.
constexpr int64_t kMaxBatchBytes = int64_t{64} << 20;

// The first contradiction found, as kInvalidArgument with the keys, their values and the remedy.
Status Validate(const Config& config);

}  // namespace dadrl
