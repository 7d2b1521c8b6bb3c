// How items are chosen, to be sampled (sampler) or to leave (remover). Items are small integers ("slots")
// that the table hands out densely and reuses.
#pragma once

#include <cstdint>
#include <memory>
#include <span>

#include "common/config/config.h"
#include "common/util/random.h"

namespace dadrl {

// Not thread safe. Every operation is O(1) or O(log n); memory is O(largest slot).
class Selector {
 public:
  struct Choice {
    uint32_t slot = 0;
    double probability = 1.0;  // of this slot in this sample
  };

  virtual ~Selector() = default;
  // `slot` is not in; `priority` is finite and not negative, and ignored where order decides.
  virtual void Insert(uint32_t slot, double priority) = 0;
  // `slot` is in.
  virtual void Delete(uint32_t slot) = 0;
  virtual void Update(uint32_t slot, double priority) = 0;
  // Not empty.
  virtual Choice Sample(Random& random) = 0;
  // The same as one Sample after the other, perhaps faster.
  virtual void SampleMany(Random& random, std::span<Choice> choices) {
    for (Choice& choice : choices) choice = Sample(random);
  }
  virtual size_t size() const = 0;
  // Memory an item costs, for the bound on it.
  virtual size_t bytes_per_item() const = 0;
};

// `priority_exponent` is the alpha of prioritised replay (Schaul et al., 2016); others ignore it.
std::unique_ptr<Selector> MakeSelector(SamplerKind kind, double priority_exponent);

}  // namespace dadrl
