// How a training begins: from nothing, or exactly where its newest whole checkpoint left it.
#pragma once

#include <cstdint>

#include "common/config/config.h"
#include "common/util/result.h"
#include "learner/algorithms/algorithm.h"
#include "learner/checkpoint_store.h"
#include "learner/trainer.h"

namespace dadrl {

// Without `resume` the store must be empty (kInvalidArgument otherwise: training would overwrite it). With it
// the newest whole checkpoint is restored into `algorithm`; a store without any begins anew, so that a
// learner killed before its first checkpoint can be restarted. Weight versions go on above both the
// checkpoint's and `highest_reserved_version`.
Result<TrainingProgress> BeginTraining(const Config& config, CheckpointStore& store,
                                       uint32_t highest_reserved_version, bool resume, Algorithm& algorithm);

}  // namespace dadrl
