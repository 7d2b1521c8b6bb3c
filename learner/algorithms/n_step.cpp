#include "learner/algorithms/n_step.h"

#include <algorithm>
#include <cassert>

namespace dadrl {
namespace {

void CopyRow(const Columns& from, int row, Columns& to, int to_row) {
  const ColumnRows source(from, row, 1);
  const MutableColumnRows target(to, to_row, 1);
  for (size_t column = 0; column < from.columns(); ++column) {
    std::ranges::copy(source.floats(column), target.floats(column).begin());
    std::ranges::copy(source.bits(column), target.bits(column).begin());
  }
}

}  // namespace

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

void FirstSteps(const TrajectoryBatch& batch, TrajectoryBatch& out) {
  assert(batch.shape.all_observations && !out.shape.all_observations);
  assert(batch.shape.steps >= out.shape.steps && batch.shape.count == out.shape.count);
  const auto copy = [](const auto& from, auto& to) { std::copy_n(from.begin(), to.size(), to.begin()); };
  for (size_t column = 0; column < out.decisions.size(); ++column) {
    copy(batch.decisions[column], out.decisions[column]);
  }
  copy(batch.rewards, out.rewards);
  copy(batch.policy_versions, out.policy_versions);
  out.weights = batch.weights;
  out.keys = batch.keys;
  for (int i = 0; i < out.shape.count; ++i) {
    const auto index = static_cast<size_t>(i);
    const bool whole = batch.steps[index] <= out.shape.steps;
    out.steps[index] = whole ? batch.steps[index] : out.shape.steps;
    out.terminated[index] = whole ? batch.terminated[index] : 0;
    out.truncated[index] = whole ? batch.truncated[index] : 0;
    CopyRow(batch.observations, i, out.observations, i);
    CopyRow(batch.observations, out.steps[index] * out.shape.count + i, out.observations,
            out.shape.count + i);
  }
}

}  // namespace dadrl
