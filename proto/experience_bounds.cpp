#include "proto/experience_bounds.h"

#include <algorithm>
#include <tuple>

#include "common/config/config_schema.h"
#include "proto/experience.h"

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

ExperienceBounds ExperienceBounds::OfAnyTask() {
  Config widest;
  widest.algorithm.gamma = 1.0;
  for (const ConfigField& field : SchemaOf(widest)) {
    // Each field takes the upper end of its own range.
    if (field.key.starts_with("task.")) std::ignore = AssignValue(field, fmt::format("{}", field.max));
  }
  return From(widest);
}

bool IsPossibleDecision(const StepSpec& spec, std::span<const float> decision) {
  if (decision.size() != spec.decision_floats()) return false;
  bool possible = true;
  for (const ColumnSpec& column : spec.decision) {
    for (const float value : decision.first(column.elements())) possible &= std::abs(value) <= column.bound;
    decision = decision.subspan(column.elements());
  }
  return possible;
}

Status CheckDecisions(const ChunkView& chunk, const StepSpec& spec) {
  std::vector<float> decision(chunk.decision_floats());
  for (int frame = 0; frame < chunk.frames(); ++frame) {
    for (size_t i = 0; i < decision.size(); ++i) decision[i] = chunk.decision(frame, i);
    if (IsPossibleDecision(spec, decision)) continue;
    const ChunkHeader header = chunk.header();
    return Fail(ErrorCode::kCorrupt,
                "actor {}, episode {}, frame {}: decision ({:.3g}) is beyond what its columns allow: {}",
                header.identity.actor, header.episode, header.first_frame + static_cast<uint32_t>(frame),
                fmt::join(decision, ", "), ColumnsText(spec.decision));
  }
  return {};
}

Status CheckRewards(const ChunkView& chunk, const ExperienceBounds& bounds) {
  for (int frame = 0; frame < chunk.frames(); ++frame) {
    if (bounds.AllowsReward(chunk.reward(frame))) continue;
    const ChunkHeader header = chunk.header();
    return Fail(ErrorCode::kCorrupt,
                "actor {}, episode {}, frame {}: reward {:g} is beyond {:.4g}, the most this task gives",
                header.identity.actor, header.episode, header.first_frame + static_cast<uint32_t>(frame),
                chunk.reward(frame), bounds.reward);
  }
  return {};
}

}  // namespace dadrl
