// Always the newest, or always the oldest item: a stack or a queue, with a limit on times sampled.
#pragma once

#include <vector>

#include "replay/sampling/selector.h"

namespace dadrl {

class OrderedSelector final : public Selector {
 public:
  enum class Order { kNewestFirst, kOldestFirst };
  explicit OrderedSelector(Order order) : order_(order) {}

  void Insert(uint32_t slot, double priority) override;
  void Delete(uint32_t slot) override;
  void Update(uint32_t, double) override {}
  Choice Sample(Random&) override {
    return {(order_ == Order::kNewestFirst ? links_[0].previous : links_[0].next) - 1, 1.0};
  }
  size_t size() const override { return size_; }
  size_t bytes_per_item() const override { return sizeof(Link); }

 private:
  // A ring in order of insertion; entry 0 is its end and its beginning, slot s is entry s + 1.
  struct Link {
    uint32_t previous = 0;
    uint32_t next = 0;
  };
  Order order_;
  std::vector<Link> links_{1};
  size_t size_ = 0;
};

}  // namespace dadrl
