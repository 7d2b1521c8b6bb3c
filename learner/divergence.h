// Tells a training that has run away from one that learns: what it estimates cannot come from the task's
// rewards.
#pragma once

#include <cstdint>

#include "common/config/config.h"
#include "common/util/result.h"
#include "learner/algorithms/algorithm.h"
#include "proto/experience_bounds.h"

namespace dadrl {

// Wide: an order of magnitude beyond the largest value that rewards and entropy can add up to, for ever. What
// is beyond it never comes back. Thread safe.
class DivergenceGuard {
 public:
  explicit DivergenceGuard(const Config& config);

  // kInternal with the estimate, its limit and the remedy. `update` counts from 1.
  Status Check(const UpdateStats& stats, uint64_t update) const;

 private:
  ExperienceBounds bounds_;
  double max_temperature_;
};

}  // namespace dadrl
