// Both critics on batches of any size, in blocks of sixteen.
#pragma once

#include <memory>

#include "common/model/value_model.h"

namespace dadrl {

// Says "q1" and "q2" with the parameters of a CriticNetwork. kInvalidArgument when a driving column is
// missing.
Result<std::unique_ptr<ValueModel>> MakeCriticValues(const StepSpec& spec, const ModelConfig& model);

}  // namespace dadrl
