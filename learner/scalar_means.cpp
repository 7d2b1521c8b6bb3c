#include "learner/scalar_means.h"

#include <algorithm>
#include <cmath>

namespace dadrl {

void ScalarMeans::Add(std::span<const double> scalars) {
  for (size_t i = 0; i < sums_.size(); ++i) {
    if (std::isnan(scalars[i])) continue;
    sums_[i] += scalars[i];
    counts_[i] += 1.0;
  }
}

std::vector<double> ScalarMeans::Take() {
  std::vector<double> means(sums_.size());
  std::ranges::transform(sums_, counts_, means.begin(), [](double sum, double count) { return sum / count; });
  std::ranges::fill(sums_, 0.0);
  std::ranges::fill(counts_, 0.0);
  return means;
}

}  // namespace dadrl
