#include "replay/sampling/uniform_selector.h"

#include "common/util/prefetch.h"

namespace dadrl {

void UniformSelector::Insert(uint32_t slot, double) {
  if (slot >= position_.size()) position_.resize(slot + size_t{1});
  position_[slot] = slots_.size();
  slots_.push_back(slot);
}

void UniformSelector::Delete(uint32_t slot) {
  const uint32_t hole = position_[slot];
  slots_[hole] = slots_.back();
  position_[slots_[hole]] = hole;
  slots_.pop_back();
}

void UniformSelector::SampleMany(Random& random, std::span<Choice> choices) {
  // Asked for before the first is read, so that the cache misses overlap.
  for (Choice& choice : choices) {
    choice.slot = random.Below(slots_.size());
    Prefetch(&slots_[choice.slot], 1);
  }
  const double probability = 1.0 / slots_.size();
  for (Choice& choice : choices) choice = {slots_[choice.slot], probability};
}

}  // namespace dadrl
