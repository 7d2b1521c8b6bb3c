#include "replay/sampling/ordered_selector.h"

namespace dadrl {

void OrderedSelector::Insert(uint32_t slot, double) {
  const uint32_t entry = slot + 1;
  if (entry >= links_.size()) links_.resize(entry + size_t{1});
  const uint32_t newest = links_[0].previous;
  links_[entry] = {newest, 0};
  links_[newest].next = entry;
  links_[0].previous = entry;
  ++size_;
}

void OrderedSelector::Delete(uint32_t slot) {
  const Link link = links_[slot + 1];
  links_[link.previous].next = link.next;
  links_[link.next].previous = link.previous;
  --size_;
}

}  // namespace dadrl
