// Weights with their running sums: samples an index in proportion to its weight.
//
// Eight children a node, one cache line of doubles each: a million weights are seven lines deep. Sums are
// recomputed from their children on every change, so they do not drift.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace dadrl {

// Not thread safe.
class SumTree {
 public:
  // Grows the tree as needed; `weight` is finite and not negative, 0 is never sampled.
  void Set(size_t index, double weight);
  double Get(size_t index) const { return index < capacity() ? levels_.front()[index] : 0.0; }
  double total() const { return total_; }
  // The index i with sum(0..i-1) <= value < sum(0..i). Total is positive; `value` in [0, total). Rounding may
  // move the borders, but never onto a weight of 0.
  size_t Find(double value) const;
  // A leaf and its share of the sums above, in a tree that is half full.
  static constexpr size_t kBytesPerWeight = 18;

 private:
  static constexpr size_t kFanout = 8;
  size_t capacity() const { return levels_.empty() ? 0 : levels_.front().size(); }
  void Grow(size_t count);

  double total_ = 0.0;
  // Leaves first, up to one node; whole nodes of kFanout sums in each.
  std::vector<std::vector<double>> levels_;
};

}  // namespace dadrl
