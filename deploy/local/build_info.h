// What results were made with.
#pragma once

#include <string>

namespace dadrl {

// Of the source tree when this was built: "1a2b3c4d5e6f", with "-dirty" when files differed from it;
// "unknown" outside a git clone.
std::string BuildCommit();

// "AMD EPYC 9B45, 2 cores".
std::string MachineName();

}  // namespace dadrl
