#include "learner/algorithms/ppo/advantages.h"

#include <algorithm>

namespace dadrl {

void EstimateAdvantages(const TrajectoryBatch& batch, std::span<const float> values,
                        std::span<const float> ratios, double gamma, double lambda, Advantages& result) {
  const auto count = static_cast<size_t>(batch.shape.count);
  result.advantage.assign(batch.rewards.size(), 0.0f);
  result.value_target.assign(batch.rewards.size(), 0.0f);
  for (size_t b = 0; b < count; ++b) {
    const auto steps = static_cast<size_t>(batch.steps[b]);
    const double bootstrap = batch.terminated[b] != 0 ? 0.0 : static_cast<double>(values[steps * count + b]);
    double next_value = bootstrap;
    double next_trace = 0.0;  // c A of the step behind
    for (size_t t = steps; t-- > 0;) {
      const size_t at = t * count + b;
      const auto value = static_cast<double>(values[at]);
      const double error = static_cast<double>(batch.rewards[at]) + gamma * next_value - value;
      const double advantage = error + gamma * lambda * next_trace;
      next_trace = std::min(1.0, static_cast<double>(ratios[at])) * advantage;
      next_value = value;
      result.advantage[at] = static_cast<float>(advantage);
      result.value_target[at] = static_cast<float>(value + next_trace);
    }
  }
}

}  // namespace dadrl
