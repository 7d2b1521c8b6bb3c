#include "learner/divergence.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace dadrl {
namespace {

// How far beyond what is possible an estimate may be for a while.
constexpr double kTolerance = 10.0;
// Nats a decision that an action's log probability comes to, clamped deviations and saturated means included.
constexpr double kMostNats = 100.0;
// Beyond it the rewards are noise beside the entropy.
constexpr double kMostTemperature = 1000.0;

}  // namespace

DivergenceGuard::DivergenceGuard(const Config& config, std::span<const ScalarSpec> specs)
    : specs_(specs),
      bounds_(ExperienceBounds::From(config)),
      max_temperature_(kMostTemperature * std::max(bounds_.reward, config.algorithm.initial_temperature)) {}

double DivergenceGuard::Limit(ScalarKind kind, double temperature) const {
  const double value = kTolerance * (bounds_.value + temperature * kMostNats * bounds_.horizon);
  switch (kind) {
    case ScalarKind::kUnbounded:
      break;
    case ScalarKind::kValue:
      return value;
    case ScalarKind::kSquaredError:
      // Of two critics, each as far from the target as both may be from zero.
      return 2.0 * (2.0 * value) * (2.0 * value);
    case ScalarKind::kTemperature:
      return max_temperature_;
  }
  return std::numeric_limits<double>::infinity();
}

Status DivergenceGuard::Check(std::span<const double> scalars, uint64_t update) const {
  double temperature = 0.0;
  for (size_t i = 0; i < specs_.size(); ++i) {
    // What is NaN is found below, and leaves the other limits as they are.
    if (specs_[i].kind == ScalarKind::kTemperature && scalars[i] > 0.0) temperature = scalars[i];
  }
  for (size_t i = 0; i < specs_.size(); ++i) {
    const double limit = Limit(specs_[i].kind, temperature);
    const double magnitude = std::abs(scalars[i]);
    if (specs_[i].kind == ScalarKind::kUnbounded || magnitude <= limit) continue;  // a NaN is not
    return Fail(
        ErrorCode::kInternal,
        "the training has run away: in update {} {} is {:.3g}, and rewards of at most {:.3g} a decision "
        "account for {:.3g}; nothing more is published or saved; resume from the last checkpoint with "
        "smaller algorithm.critic_learning_rate and algorithm.actor_learning_rate, or with other experience",
        update, specs_[i].name, magnitude, bounds_.reward, limit);
  }
  return {};
}

}  // namespace dadrl
