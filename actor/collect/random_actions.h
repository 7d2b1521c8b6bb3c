// Exploration before there is a policy: uniform actions, each held long enough to move the car.
#pragma once

#include "common/step/driving_shape.h"
#include "common/util/random.h"

namespace dadrl {

// Each action is uniform in (-1, 1)^2 and held for a uniform time of 0 to 1 s, one decision at least: a fresh
// draw every decision would average out to driving straight at half speed. Not thread safe.
class RandomActions {
 public:
  // `decision_s`: simulated seconds a decision lasts.
  explicit RandomActions(double decision_s) : decision_s_(decision_s) {}

  // Call at the start of an episode: the next action is a fresh draw.
  void Restart() { left_ = 0; }
  Action Next(Random& random);

 private:
  const double decision_s_;
  int left_ = 0;  // decisions that the action is still held
  Action action_{};
};

}  // namespace dadrl
