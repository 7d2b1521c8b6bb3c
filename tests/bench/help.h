// --help of a benchmark.
#pragma once

#include <cstdio>
#include <span>
#include <string_view>

namespace dadrl::bench {

// Prints `usage` when it is asked for; then the benchmark has nothing else to do.
inline bool HelpAsked(int argc, char** argv, std::string_view usage) {
  for (const std::string_view argument : std::span(argv, static_cast<size_t>(argc)).subspan(1)) {
    if (argument != "--help" && argument != "-h") continue;
    std::fwrite(usage.data(), 1, usage.size(), stdout);
    return true;
  }
  return false;
}

}  // namespace dadrl::bench
