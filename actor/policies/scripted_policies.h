// The drivers that need no learning and no prediction.
#pragma once

#include "actor/policies/driving_policy.h"
#include "common/util/random.h"

namespace dadrl {

// The lane command that brings the ego onto its route: 0 while it is within 0.8 m of it.
int LaneTowardsRoute(const DrivingEnvironment& environment);

// Uniform actions, each held `hold_steps` simulation steps; drawn from the episode's seed.
class RandomPolicy final : public DrivingPolicy {
 public:
  explicit RandomPolicy(int hold_steps) : hold_steps_(hold_steps) {}
  void BeginEpisode(uint64_t seed) override;
  Decision Decide(const DrivingEnvironment& environment) override;

 private:
  int hold_steps_;
  Random random_{0};
};

// One speed for ever, whoever is in the way.
class ConstantSpeedPolicy final : public DrivingPolicy {
 public:
  enum class Lane { kKeep, kRoute };
  ConstantSpeedPolicy(double speed_mps, Lane lane) : speed_mps_(speed_mps), lane_(lane) {}
  Decision Decide(const DrivingEnvironment& environment) override;

 private:
  double speed_mps_;
  Lane lane_;
};

// For an environment in which SUMO drives: commands nothing.
class SumoDriverPolicy final : public DrivingPolicy {
 public:
  Decision Decide(const DrivingEnvironment&) override { return {}; }
};

}  // namespace dadrl
