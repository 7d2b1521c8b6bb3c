#include "replay/sampling/heap_selector.h"

namespace dadrl {

void HeapSelector::Insert(uint32_t slot, double priority) {
  if (slot >= position_.size()) position_.resize(slot + size_t{1});
  heap_.push_back({sign_ * priority, ++changes_, slot});
  Settle(heap_.size() - 1);
}

void HeapSelector::Delete(uint32_t slot) {
  const size_t hole = position_[slot];
  const Entry last = heap_.back();
  heap_.pop_back();
  if (hole == heap_.size()) return;
  Place(hole, last);
  Settle(hole);
}

void HeapSelector::Update(uint32_t slot, double priority) {
  const size_t index = position_[slot];
  heap_[index] = {sign_ * priority, ++changes_, slot};
  Settle(index);
}

void HeapSelector::Settle(size_t index) {
  const Entry entry = heap_[index];
  for (; index > 0 && entry < heap_[(index - 1) / 2]; index = (index - 1) / 2) {
    Place(index, heap_[(index - 1) / 2]);
  }
  for (size_t child = 2 * index + 1; child < heap_.size(); child = 2 * index + 1) {
    if (child + 1 < heap_.size() && heap_[child + 1] < heap_[child]) ++child;
    if (!(heap_[child] < entry)) break;
    Place(index, heap_[child]);
    index = child;
  }
  Place(index, entry);
}

void HeapSelector::Place(size_t index, const Entry& entry) {
  heap_[index] = entry;
  position_[entry.slot] = index;
}

}  // namespace dadrl
