// A benchmark's figures: one JSON line each on standard output, beside the limit that was measured in the
// same run. `of_limit` nears 1 from below as the figure nears its limit, and is above 1 where it beats a
// peer.
#pragma once

#include <fmt/core.h>

#include <cstdio>
#include <string_view>

namespace dadrl::bench {

inline void PrintFigure(std::string_view bench, std::string_view name, double value, std::string_view unit,
                        double limit, double of_limit) {
  fmt::print(R"({{"bench": "{}", "case": "{}", "value": {:.4g}, "unit": "{}", "limit": {:.4g}, )"
             R"("of_limit": {:.3f}}})"
             "\n",
             bench, name, value, unit, limit, of_limit);
  std::fflush(stdout);
}

// Larger is better.
inline void PrintRate(std::string_view bench, std::string_view name, double value, std::string_view unit,
                      double limit) {
  PrintFigure(bench, name, value, unit, limit, value / limit);
}

// Smaller is better.
inline void PrintCost(std::string_view bench, std::string_view name, double value, std::string_view unit,
                      double limit) {
  PrintFigure(bench, name, value, unit, limit, limit / value);
}

}  // namespace dadrl::bench
