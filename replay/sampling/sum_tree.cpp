#include "replay/sampling/sum_tree.h"

#include <algorithm>

namespace dadrl {

void SumTree::Set(size_t index, double weight) {
  if (index >= capacity()) Grow(index + 1);
  double sum = weight;
  for (auto& level : levels_) {
    level[index] = sum;
    const double* node = &level[index / kFanout * kFanout];
    sum = ((node[0] + node[1]) + (node[2] + node[3])) + ((node[4] + node[5]) + (node[6] + node[7]));
    index /= kFanout;
  }
  total_ = sum;
}

size_t SumTree::Find(double value) const {
  size_t node = 0;
  for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
    const double* sums = &(*level)[node * kFanout];
    size_t child = kFanout;
    for (size_t i = 0; i < kFanout; ++i) {
      if (sums[i] <= 0.0) continue;
      child = i;
      if (value < sums[i]) break;
      value -= sums[i];
    }
    node = node * kFanout + child;
  }
  return node;
}

void SumTree::Grow(size_t count) {
  size_t nodes = (std::max(count, 2 * capacity()) + kFanout - 1) / kFanout;
  for (size_t level = 0;; ++level) {
    const bool added = level == levels_.size();
    if (added) levels_.emplace_back();
    levels_[level].resize(nodes * kFanout, 0.0);
    // The top of the smaller tree was one node, the first of the level it stood on: its sum is the total.
    if (added) levels_[level][0] = total_;
    if (nodes == 1) return;
    nodes = (nodes + kFanout - 1) / kFanout;
  }
}

}  // namespace dadrl
