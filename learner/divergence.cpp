#include "learner/divergence.h"

#include <algorithm>
#include <cmath>

namespace dadrl {
namespace {

// How far beyond what is possible an estimate may be for a while.
constexpr double kTolerance = 10.0;
// Nats a decision that an action's log probability comes to, clamped deviations and saturated means included.
constexpr double kMostNats = 100.0;
// Beyond it the rewards are noise beside the entropy.
constexpr double kMostTemperature = 1000.0;

}  // namespace

DivergenceGuard::DivergenceGuard(const Config& config)
    : bounds_(ExperienceBounds::From(config)),
      max_temperature_(kMostTemperature * std::max(bounds_.reward, config.algorithm.initial_temperature)) {}

Status DivergenceGuard::Check(const UpdateStats& stats, uint64_t update) const {
  const double value = kTolerance * (bounds_.value + stats.temperature * kMostNats * bounds_.horizon);
  const struct {
    const char* name;
    double is;
    double most;
  } estimates[] = {{"the temperature", stats.temperature, max_temperature_},
                   {"the mean target value", std::abs(stats.mean_target), value},
                   {"the mean Q value", std::abs(stats.mean_q), value},
                   // Of two critics, each as far from the target as both may be from zero.
                   {"the critic loss", stats.critic_loss, 2.0 * (2.0 * value) * (2.0 * value)}};
  for (const auto& estimate : estimates) {
    if (estimate.is <= estimate.most) continue;  // a NaN is not
    return Fail(
        ErrorCode::kInternal,
        "the training has run away: in update {} {} is {:.3g}, and rewards of at most {:.3g} a decision "
        "account for {:.3g}; nothing more is published or saved; resume from the last checkpoint with "
        "smaller "
        "algorithm.critic_learning_rate and algorithm.actor_learning_rate, or with other experience",
        update, estimate.name, estimate.is, bounds_.reward, estimate.most);
  }
  return {};
}

}  // namespace dadrl
