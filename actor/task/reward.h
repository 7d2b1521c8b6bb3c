// The reward: eight weighted terms (paper, section IV; weights of the released code are the defaults of
// RewardConfig).
#pragma once

#include "actor/sensing/localization.h"
#include "actor/task/events.h"
#include "common/config/config.h"

namespace dadrl {

// Each already weighted; the reward of a step is their sum.
struct RewardTerms {
  double crash = 0.0;
  double off_road = 0.0;
  double goal = 0.0;
  double progress = 0.0;   // weight * fraction of the route driven in this step; negative when driven back
  double speed = 0.0;      // weight * v / limit up to the limit, weight * -(v - limit) / limit above it
  double off_route = 0.0;  // each step
  double wrong_way = 0.0;  // each step
  double slow = 0.0;       // at every hundredth consecutive step below a tenth of the limit

  double Sum() const { return crash + off_road + goal + progress + speed + off_route + wrong_way + slow; }
};

// Seconds below a tenth of the limit that earn one slow penalty.
constexpr double kSlowSeconds = 10.0;
constexpr double kSlowFraction = 0.1;

// The reward of one episode, step after step. Not thread safe.
class RewardFunction {
 public:
  explicit RewardFunction(const RewardConfig& weights) : weights_(weights) {}

  // `remaining`: fraction of the route at the start.
  void Begin(double remaining);
  // Once a step. Of the three ends only the first that holds counts: collision, off-road, goal. The speed
  // term is 0 off the lanes (no limit there), and where the ego is off its route or against its lane; a limit
  // below kSlowestLimit counts as that much.
  RewardTerms Step(double speed_mps, const EgoLocation& location, const Events& events);

 private:
  double SpeedTerm(double speed_mps, double limit, bool astray) const;

  RewardConfig weights_;
  double remaining_ = 1.0;
  int slow_steps_ = 0;
};

}  // namespace dadrl
