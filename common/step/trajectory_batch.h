// What a learner trains on: stretches of episodes, as many as it asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/step/columns.h"

namespace dadrl {

struct TrajectoryShape {
  int count = 1;                  // trajectories, B
  int steps = 1;                  // of each, at most, L
  bool all_observations = false;  // that of every step; else the first, and the one behind the last step

  int observations() const { return all_observations ? steps + 1 : 2; }
  bool operator==(const TrajectoryShape&) const = default;
};

// Trajectory b has steps[b] steps: fewer than L only where its episode ended, then an end is its last step.
// Arrays of steps are [L, B, ...], time first, so that the rows of one step lie together; what lies behind a
// trajectory's last step is zero.
struct TrajectoryBatch {
  TrajectoryShape shape;
  // [observations(), B]: of step t (with all of them), or of the first step and behind the last. Nothing
  // follows a termination: the observation behind it is zero.
  Columns observations;
  std::vector<std::vector<float>> decisions;  // by decision column: [L, B, its elements]
  std::vector<float> rewards;                 // [L, B]
  std::vector<uint32_t> policy_versions;      // [L, B], of the policy that acted
  std::vector<int> steps;                     // [B]
  std::vector<uint8_t> terminated;            // [B]: do not bootstrap
  std::vector<uint8_t> truncated;             // [B]: the time limit; bootstrap from the observation behind
  std::vector<float> weights;                 // [B], importance weights, 1 for uniform replay
  std::vector<uint64_t> keys;                 // [B], of the items, for priorities

  TrajectoryBatch(const StepSpec& spec, const TrajectoryShape& batch_shape)
      : shape(batch_shape), observations(spec, shape.observations() * shape.count) {
    const auto count = static_cast<size_t>(shape.count);
    const size_t cells = count * static_cast<size_t>(shape.steps);
    for (const ColumnSpec& column : spec.decision) decisions.emplace_back(cells * column.elements());
    rewards.resize(cells);
    policy_versions.resize(cells);
    steps.resize(count);
    terminated.resize(count);
    truncated.resize(count);
    weights.assign(count, 1.0f);
    keys.resize(count);
  }

  // The observations of all trajectories at `index` of [0, shape.observations()).
  ColumnRows ObservationsAt(int index) const { return {observations, index * shape.count, shape.count}; }
  // [B, elements] of decision column `column` at step `t`.
  std::span<const float> DecisionsAt(size_t column, int t) const {
    const std::vector<float>& all = decisions[column];
    const size_t length = all.size() / static_cast<size_t>(shape.steps);
    return std::span(all).subspan(static_cast<size_t>(t) * length, length);
  }
};

}  // namespace dadrl
