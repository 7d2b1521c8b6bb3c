// What an algorithm's scalars come to over an interval of training.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace dadrl {

// Means, each over the updates that gave the scalar. Not thread safe.
class ScalarMeans {
 public:
  explicit ScalarMeans(size_t count) : sums_(count), counts_(count) {}

  // Those of one update, as Algorithm::scalars; NaN: it has none. Allocates nothing.
  void Add(std::span<const double> scalars);
  // NaN where no update gave one. Begins a new interval.
  std::vector<double> Take();

 private:
  std::vector<double> sums_;
  std::vector<double> counts_;
};

}  // namespace dadrl
