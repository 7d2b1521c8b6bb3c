// Tells a training that has run away from one that learns: what it estimates cannot come from the task's
// rewards.
#pragma once

#include <cstdint>
#include <span>

#include "common/config/config.h"
#include "common/util/result.h"
#include "learner/algorithms/scalar.h"
#include "proto/experience_bounds.h"

namespace dadrl {

// Wide: an order of magnitude beyond the largest value that rewards and entropy can add up to, for ever. What
// is beyond it never comes back. Thread safe.
class DivergenceGuard {
 public:
  // `specs`: of the scalars that Check gets; borrowed.
  DivergenceGuard(const Config& config, std::span<const ScalarSpec> specs);

  // kInternal with the scalar, its limit and the remedy; one that has a limit must not be NaN. `update`
  // counts from 1.
  Status Check(std::span<const double> scalars, uint64_t update) const;

 private:
  // The largest magnitude of a scalar of this kind at a temperature.
  double Limit(ScalarKind kind, double temperature) const;

  std::span<const ScalarSpec> specs_;
  ExperienceBounds bounds_;
  double max_temperature_;
};

}  // namespace dadrl
