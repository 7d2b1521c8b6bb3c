#include "learner/algorithms/n_step.h"

#include <cassert>

namespace dadrl {

Transitions NStepReturns::Of(const TrajectoryBatch& batch) {
  assert(!batch.shape.all_observations);
  const auto count = static_cast<size_t>(batch.shape.count);
  reward_.resize(count);
  discount_.resize(count);
  for (size_t i = 0; i < count; ++i) {
    double sum = 0.0;
    double factor = 1.0;
    for (size_t t = 0; std::cmp_less(t, batch.steps[i]); ++t, factor *= gamma_) {
      sum += factor * double{batch.rewards[t * count + i]};
    }
    reward_[i] = sum;
    discount_[i] = batch.terminated[i] != 0 ? 0.0f : static_cast<float>(factor);
  }
  return {.observation = batch.ObservationsAt(0),
          .next_observation = batch.ObservationsAt(1),
          .action = batch.DecisionsAt(0, 0),
          .reward = reward_,
          .discount = discount_,
          .weight = batch.weights};
}

}  // namespace dadrl
