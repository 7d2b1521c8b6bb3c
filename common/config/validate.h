// Checks that involve more than one key; ranges of single keys are in config_schema.cpp.
#pragma once

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// The first contradiction found, as kInvalidArgument with the keys, their values and the remedy.
Status Validate(const Config& config);

}  // namespace dadrl
