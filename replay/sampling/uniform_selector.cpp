#include "replay/sampling/uniform_selector.h"

namespace dadrl {

void UniformSelector::Insert(uint32_t slot, double) {
  if (slot >= position_.size()) position_.resize(slot + size_t{1});
  position_[slot] = static_cast<uint32_t>(slots_.size());
  slots_.push_back(slot);
}

void UniformSelector::Delete(uint32_t slot) {
  const uint32_t hole = position_[slot];
  slots_[hole] = slots_.back();
  position_[slots_[hole]] = hole;
  slots_.pop_back();
}

}  // namespace dadrl
