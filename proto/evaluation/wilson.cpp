#include "proto/evaluation/wilson.h"

#include <algorithm>
#include <cmath>

namespace dadrl {

std::pair<double, double> WilsonInterval(int hits, int trials) {
  if (trials <= 0) return {0.0, 1.0};
  constexpr double kZ = 1.959963984540054;  // 97.5 % quantile of the normal distribution
  const double n = trials;
  const double rate = hits / n;
  const double scale = 1.0 + kZ * kZ / n;
  const double centre = (rate + kZ * kZ / (2 * n)) / scale;
  const double half = kZ / scale * std::sqrt(rate * (1 - rate) / n + kZ * kZ / (4 * n * n));
  return {hits == 0 ? 0.0 : std::max(0.0, centre - half),
          hits == trials ? 1.0 : std::min(1.0, centre + half)};
}

}  // namespace dadrl
