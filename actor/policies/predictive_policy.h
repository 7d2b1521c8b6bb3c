// A rule-based driver that needs no learning: shows that a scenario can be driven, independent of SUMO's
// driver model.
#pragma once

#include <array>
#include <vector>

#include "actor/policies/driving_policy.h"

namespace dadrl {

// Every step: everyone else keeps speed and turn rate for four seconds; the ego takes the fastest of
// {10, 8, 6, 4, 2, 0} m/s, on its route's lane if it can, whose drive on its own controller and bicycle stays
// on the road and clear of them all; when none does, the one that stays clear the longest.
class PredictivePolicy final : public DrivingPolicy {
 public:
  void BeginEpisode(uint64_t seed) override;
  Decision Decide(const DrivingEnvironment& environment) override;

 private:
  static constexpr int kHorizonSteps = 40;
  static constexpr int kTurnSteps = 5;  // a turn rate is measured over this many steps
  using Trajectory = std::array<OrientedBox, kHorizonSteps>;

  void Predict(const WorldState& world);
  double TurnRate(const SocialVehicle& vehicle) const;
  // Steps until the drive leaves the road or comes too close to someone; kHorizonSteps when it never does, or
  // not before the goal.
  int ClearSteps(const DrivingEnvironment& environment, const DriveCommand& command) const;

  std::array<std::vector<SocialVehicle>, kTurnSteps> past_;  // ring of scenes
  int scenes_ = 0;
  std::vector<Trajectory> others_;
};

}  // namespace dadrl
