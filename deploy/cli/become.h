// Commands that another program of this installation carries out.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// Replaces this process by `program`, which stands beside it, with these arguments; returns only when it
// cannot.
Result<int> Become(std::string_view program, std::vector<std::string> arguments);

}  // namespace dadrl
