#include "actor/task/reward.h"

#include <algorithm>
#include <cmath>

#include "actor/sim/world_state.h"
#include "proto/experience_bounds.h"

namespace dadrl {

void RewardFunction::Begin(double remaining) {
  remaining_ = remaining;
  slow_steps_ = 0;
}

double RewardFunction::SpeedTerm(double speed_mps, double limit, bool astray) const {
  if (limit <= 0.0) return 0.0;
  limit = std::max(limit, kSlowestLimit);
  if (speed_mps > limit) return -weights_.speed * (speed_mps - limit) / limit;
  return astray ? 0.0 : weights_.speed * speed_mps / limit;
}

RewardTerms RewardFunction::Step(double speed_mps, const EgoLocation& location, const Events& events) {
  static const int slow_period = std::lround(kSlowSeconds / kStepSeconds);
  RewardTerms terms;
  if (events.collision) {
    terms.crash = weights_.crash;
  } else if (events.off_road) {
    terms.off_road = weights_.off_road;
  } else if (events.goal) {
    terms.goal = weights_.goal;
  }
  terms.progress = weights_.progress * (remaining_ - location.remaining);
  remaining_ = location.remaining;
  terms.speed = SpeedTerm(speed_mps, location.speed_limit, events.off_route || events.wrong_way);
  if (events.off_route) terms.off_route = weights_.off_route;
  if (events.wrong_way) terms.wrong_way = weights_.wrong_way;

  slow_steps_ = speed_mps < kSlowFraction * location.speed_limit ? slow_steps_ + 1 : 0;
  if (slow_steps_ > 0 && slow_steps_ % slow_period == 0) terms.slow = weights_.slow;
  return terms;
}

}  // namespace dadrl
