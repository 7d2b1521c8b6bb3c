#include "actor/collect/random_actions.h"

#include <algorithm>
#include <cmath>

namespace dadrl {

Action RandomActions::Next(Random& random) {
  if (left_ == 0) {
    for (float& element : action_) element = random.Uniform(-1.0, 1.0);
    left_ = std::max<int>(1, std::lround(random.Uniform() / decision_s_));
  }
  --left_;
  return action_;
}

}  // namespace dadrl
