// Every item with the same probability.
#pragma once

#include <vector>

#include "replay/sampling/selector.h"

namespace dadrl {

class UniformSelector final : public Selector {
 public:
  void Insert(uint32_t slot, double priority) override;
  void Delete(uint32_t slot) override;
  void Update(uint32_t, double) override {}
  Choice Sample(Random& random) override {
    return {slots_[random.Below(slots_.size())], 1.0 / slots_.size()};
  }
  void SampleMany(Random& random, std::span<Choice> choices) override;
  size_t size() const override { return slots_.size(); }
  size_t bytes_per_item() const override { return 2 * sizeof(uint32_t); }

 private:
  std::vector<uint32_t> slots_;     // those that are in, in any order
  std::vector<uint32_t> position_;  // of each slot within slots_
};

}  // namespace dadrl
