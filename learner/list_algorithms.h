// What `dadrl algorithms` prints: the table of learning algorithms.
#pragma once

#include <string>

namespace dadrl {

// A line each; with `json` one object with what each declares, too.
std::string AlgorithmList(bool json);

}  // namespace dadrl
