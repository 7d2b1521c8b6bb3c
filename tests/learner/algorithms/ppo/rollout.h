// Rollouts for the tests of PPO.
#pragma once

#include <vector>

#include "common/config/config.h"
#include "common/step/driving_shape.h"
#include "common/step/trajectory_batch.h"
#include "tests/driving_columns.h"
#include "tests/golden/golden.h"

namespace dadrl {

// What a small PPO needs; `rollout` decisions in trajectories of `length`.
inline Config SmallPpo(int rollout, int length) {
  Config config;
  config.algorithm.name = "ppo";
  config.algorithm.batch_size = 16;
  config.algorithm.rollout = rollout;
  config.model.stae = false;
  config.model.log_probability = true;
  config.model.hidden = 32;
  config.replay.sequence_length = length;
  config.replay.sequence_period = length;
  return config;
}

// Any rollout: plausible values; trajectory 1 terminates after two decisions, trajectory 2 is truncated after
// three. The same for the same salt.
inline TrajectoryBatch AnyRollout(const Config& config, const TrajectoryShape& shape, uint64_t salt) {
  TrajectoryBatch batch(DrivingStepSpec(config), shape);
  const auto fill = [&](std::span<float> values, float scale) {
    std::ranges::copy(golden::Uniform(salt++, values.size(), scale), values.begin());
  };
  fill(VehiclesOf(batch.observations), 1.0f);
  fill(EgoOf(batch.observations), 1.0f);
  fill(batch.decisions[0], 0.9f);
  fill(batch.decisions[1], 1.0f);
  fill(batch.rewards, 1.0f);
  std::ranges::fill(batch.steps, shape.steps);
  batch.steps[1] = 2;
  batch.terminated[1] = 1;
  batch.steps[2] = 3;
  batch.truncated[2] = 1;
  return batch;
}

}  // namespace dadrl
