// Always the item of the highest, or always that of the lowest priority; among equals the one that has had
// its priority for longest.
#pragma once

#include <vector>

#include "replay/sampling/selector.h"

namespace dadrl {

class HeapSelector final : public Selector {
 public:
  enum class Order { kHighestFirst, kLowestFirst };
  explicit HeapSelector(Order order) : sign_(order == Order::kHighestFirst ? -1.0 : 1.0) {}

  void Insert(uint32_t slot, double priority) override;
  void Delete(uint32_t slot) override;
  void Update(uint32_t slot, double priority) override;
  Choice Sample(Random&) override { return {heap_.front().slot, 1.0}; }
  size_t size() const override { return heap_.size(); }
  size_t bytes_per_item() const override { return sizeof(Entry) + sizeof(uint32_t); }

 private:
  struct Entry {
    double cost = 0.0;   // the lowest is sampled
    uint64_t since = 0;  // counts inserts and updates
    uint32_t slot = 0;
    bool operator<(const Entry& other) const {
      return cost != other.cost ? cost < other.cost : since < other.since;
    }
  };
  // Moves the entry at `index` to where it belongs.
  void Settle(size_t index);
  void Place(size_t index, const Entry& entry);

  const double sign_;
  uint64_t changes_ = 0;
  std::vector<Entry> heap_;         // a binary heap, the least entry first
  std::vector<uint32_t> position_;  // of each slot within heap_
};

}  // namespace dadrl
