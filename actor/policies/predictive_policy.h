// A rule-based driver that needs no learning: shows that a scenario can be driven, independent of SUMO's
// driver model.
#pragma once

#include <array>
#include <vector>

#include "actor/policies/driving_policy.h"

namespace dadrl {

// Each time that it is asked: everyone else keeps speed and turn rate for four seconds; the ego takes the
// fastest of {10, 8, 6, 4, 2, 0} m/s, on its route's lane if it can, whose drive on its own controller and
// bicycle stays on the road and clear of them all; when none does, the one that stays clear the longest.
class PredictivePolicy final : public DrivingPolicy {
 public:
  void BeginEpisode(uint64_t seed) override;
  Decision Decide(const DrivingEnvironment& environment) override;

 private:
  static constexpr int kHorizonSteps = 40;
  static constexpr int kTurnScenes = 5;  // a turn rate is measured over this many scenes
  using Trajectory = std::array<OrientedBox, kHorizonSteps>;

  // `step`: simulation steps since the spawn.
  void Predict(const WorldState& world, int step);
  double TurnRate(const SocialVehicle& vehicle, int step) const;
  // Steps until the drive leaves the road or comes too close to someone; kHorizonSteps when it never does, or
  // not before the goal.
  int ClearSteps(const DrivingEnvironment& environment, const DriveCommand& command) const;

  struct Scene {
    int step = 0;
    std::vector<SocialVehicle> vehicles;
  };
  std::array<Scene, kTurnScenes> past_;  // ring
  int scenes_ = 0;
  std::vector<Trajectory> others_;
};

}  // namespace dadrl
