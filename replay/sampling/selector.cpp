#include "replay/sampling/selector.h"

#include "replay/sampling/heap_selector.h"
#include "replay/sampling/ordered_selector.h"
#include "replay/sampling/prioritized_selector.h"
#include "replay/sampling/uniform_selector.h"

namespace dadrl {

std::unique_ptr<Selector> MakeSelector(SamplerKind kind, double priority_exponent) {
  switch (kind) {
    case SamplerKind::kUniform:
      return std::make_unique<UniformSelector>();
    case SamplerKind::kPrioritized:
      return std::make_unique<PrioritizedSelector>(priority_exponent);
    case SamplerKind::kNewestFirst:
      return std::make_unique<OrderedSelector>(OrderedSelector::Order::kNewestFirst);
    case SamplerKind::kOldestFirst:
      return std::make_unique<OrderedSelector>(OrderedSelector::Order::kOldestFirst);
    case SamplerKind::kHighestPriority:
      return std::make_unique<HeapSelector>(HeapSelector::Order::kHighestFirst);
    case SamplerKind::kLowestPriority:
      return std::make_unique<HeapSelector>(HeapSelector::Order::kLowestFirst);
  }
  return nullptr;
}

}  // namespace dadrl
