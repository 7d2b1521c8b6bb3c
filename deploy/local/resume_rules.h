// Which keys may differ when a run goes on.
#pragma once

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// kInvalidArgument naming the first key that the weights or the stored experience of the run depend on and
// that differs between `run` (its config.yaml) and `wanted`.
Status CheckResumable(const Config& run, const Config& wanted);

}  // namespace dadrl
