#include "proto/experience_bounds.h"

#include <algorithm>

namespace dadrl {
namespace {

// Of rewards that were summed in double and are stored as float.
constexpr double kRounding = 1.0 + 1e-5;
// Decisions beyond which nothing counts: the longest episode that a configuration allows.
constexpr double kLongestHorizon = 100000.0;

// The terms of actor/task/reward.h, each at its largest: one end; the whole route at once, since progress of
// several steps adds up to no more; the other terms in each step; one slow penalty, since they are ten
// seconds apart.
double LargestReward(const TaskConfig& task) {
  const RewardConfig& weights = task.reward;
  const double end = std::max({std::abs(weights.crash), std::abs(weights.off_road), std::abs(weights.goal)});
  const double speed = std::abs(weights.speed) * std::max(1.0, task.max_speed_mps / kSlowestLimit);
  const double step = speed + std::abs(weights.off_route) + std::abs(weights.wrong_way);
  return end + std::abs(weights.progress) + task.decision_interval * step + std::abs(weights.slow);
}

}  // namespace

ExperienceBounds ExperienceBounds::From(const Config& config) {
  ExperienceBounds bounds;
  bounds.reward = kRounding * LargestReward(config.task);
  const double left = 1.0 - config.algorithm.gamma;
  bounds.horizon = left * kLongestHorizon > 1.0 ? 1.0 / left : kLongestHorizon;
  bounds.value = bounds.reward * bounds.horizon;
  bounds.priority = 2.0 * bounds.value;
  return bounds;
}

bool IsPossibleAction(const Action& action) {
  return std::ranges::all_of(action, [](float value) { return std::abs(value) <= 1.0f; });
}

bool ArePossibleFeatures(std::span<const float> features) {
  return std::ranges::all_of(features,
                             [](float value) { return std::abs(value) <= ObservationSpec::kFeatureBound; });
}

}  // namespace dadrl
