// The key of runs that tests make by hand.
#pragma once

#include <string>

namespace dadrl {

inline const std::string kTestRunKey(32, '5');

}  // namespace dadrl
