// What the name of a learning algorithm stands for: a preset, NAME.yaml, which comes with the program.
#pragma once

#include <string>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// The defaults with the preset of `algorithm` over them: ../share/dadrl/algorithms/NAME.yaml beside the
// folder of this program. kInvalidArgument with all names and the nearest one when there is none, kNotFound
// when no preset is installed at all; LoadYaml's errors.
Result<Config> LoadPreset(const std::string& algorithm);

}  // namespace dadrl
