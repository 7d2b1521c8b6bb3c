// Columns as JSON: how stored and exported experience says what it holds.
//
//   {"observation": [{"name": "ego", "type": "float32", "shape": [5, 20], "codec": "history", "bound": 5.0},
//   ...],
//    "decision": [...]}
#pragma once

#include <nlohmann/json.hpp>
#include <string_view>

#include "common/step/step_spec.h"

namespace dadrl {

nlohmann::ordered_json StepSpecToJson(const StepSpec& spec);

// kCorrupt, with `origin` in front: no such description, or one that CheckSpec refuses.
Result<StepSpec> StepSpecFromJson(const nlohmann::ordered_json& json, std::string_view origin);

// The same for the index of an export in the first format: {"vehicles": 6, "history": 5}.
Result<StepSpec> SpecInFirstFormat(const nlohmann::ordered_json& json, std::string_view origin);

}  // namespace dadrl
