// Experience from before steps were described by columns: all of it was of one kind.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "common/step/step_spec.h"

namespace dadrl {

StepSpec FirstFormatSpec(int vehicles, int history);

// What such steps of `spec` were hashed to; nothing for other steps. It is their hash still.
std::optional<uint64_t> HashInFirstFormat(const StepSpec& spec);

// The steps that were hashed to `schema`: a hash names them only to who tries them all; there are few.
std::optional<StepSpec> SpecOfFirstFormat(uint64_t schema);

// What the exported array `name` was called.
std::string_view ArrayNameInFirstFormat(std::string_view name);

}  // namespace dadrl
