// Traffic seeds as a user or a program writes them: "1000000:50".
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// `count` seeds: first, first + 1, ...
struct SeedRange {
  uint64_t first = 0;
  int count = 1;
  bool operator==(const SeedRange&) const = default;
};

// "FIRST:COUNT" with a count of 1 to a million; kInvalidArgument otherwise.
Result<SeedRange> ParseSeedRange(const std::string& text);
std::string ToText(const SeedRange& range);

}  // namespace dadrl
