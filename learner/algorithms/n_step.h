// Trajectories as transitions over several steps: what one-step temporal-difference methods train on.
#pragma once

#include <span>
#include <vector>

#include "common/step/trajectory_batch.h"

namespace dadrl {

// Borrowed; row b is trajectory b, whose first step is t and which has k steps.
struct Transitions {
  ColumnRows observation;           // at t
  ColumnRows next_observation;      // at t + k; zero where the episode terminated (discount is 0)
  std::span<const float> action;    // [B, 2], at t
  std::span<const float> reward;    // [B], sum over i < k of gamma^i r_(t+i)
  std::span<const float> discount;  // [B], gamma^k, or 0 where the episode terminated
  std::span<const float> weight;    // [B], importance weights

  int size() const { return observation.rows(); }
};

// Keeps the memory of the sums. Not thread safe.
class NStepReturns {
 public:
  NStepReturns(double gamma, int most) : gamma_(gamma) {
    reward_.reserve(static_cast<size_t>(most));
    discount_.reserve(static_cast<size_t>(most));
  }

  // Of a batch without the observations in between, whose first decision column is the action. Valid until
  // the next call, and as long as the batch.
  Transitions Of(const TrajectoryBatch& batch);

 private:
  double gamma_;
  std::vector<float> reward_;
  std::vector<float> discount_;
};

// Fills `out`, of steps L and without the observations in between, with the first L steps of a batch that has
// all observations and at least as many steps.
void FirstSteps(const TrajectoryBatch& batch, TrajectoryBatch& out);

}  // namespace dadrl
