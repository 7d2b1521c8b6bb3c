// How much better than expected each action of a rollout turned out to be.
#pragma once

#include <span>
#include <vector>

#include "common/step/trajectory_batch.h"

namespace dadrl {

// [L, B], zero behind a trajectory's last step.
struct Advantages {
  std::vector<float> advantage;
  std::vector<float> value_target;
};

// Generalised advantage estimates (Schulman et al. 2016) whose traces are cut where the policy of now would
// hardly have done what was done (Espeholt et al. 2018, V-trace with both bounds 1):
//
//   A_t = r_t + gamma V(s_t+1) - V(s_t) + gamma lambda c_t+1 A_t+1,  c = min(1, pi(a|s) / mu(a|s))
//   value target = V(s_t) + c_t A_t
//
// On policy, c is 1, and that is GAE. A terminated trajectory has no value behind its last step, a truncated
// one and one that ends at L have that of the observation behind it.
//
// `batch` holds all observations; `values` [L + 1, B] are theirs, `ratios` [L, B] are pi / mu. Keeps the
// memory of `result`.
void EstimateAdvantages(const TrajectoryBatch& batch, std::span<const float> values,
                        std::span<const float> ratios, double gamma, double lambda, Advantages& result);

}  // namespace dadrl
