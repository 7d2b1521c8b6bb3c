// In proportion to priority^alpha (Schaul et al., 2016).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "replay/sampling/selector.h"
#include "replay/sampling/sum_tree.h"

namespace dadrl {

class PrioritizedSelector final : public Selector {
 public:
  explicit PrioritizedSelector(double exponent) : exponent_(exponent) {}

  void Insert(uint32_t slot, double priority) override {
    tree_.Set(slot, Weight(priority));
    ++size_;
  }
  void Delete(uint32_t slot) override {
    tree_.Set(slot, 0.0);
    --size_;
  }
  void Update(uint32_t slot, double priority) override { tree_.Set(slot, Weight(priority)); }
  Choice Sample(Random& random) override {
    const size_t slot = tree_.Find(random.Uniform() * tree_.total());
    return {static_cast<uint32_t>(slot), tree_.Get(slot) / tree_.total()};
  }
  size_t size() const override { return size_; }
  size_t bytes_per_item() const override { return SumTree::kBytesPerWeight; }

 private:
  // Kept above 0: an item whose error vanished is as good as never sampled, but it is there.
  double Weight(double priority) const { return std::max(std::pow(priority, exponent_), kMinWeight); }

  static constexpr double kMinWeight = 1e-12;
  double exponent_;
  SumTree tree_;
  size_t size_ = 0;
};

}  // namespace dadrl
