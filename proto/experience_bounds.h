// What one frame of experience can hold: what is beyond these bounds was not made by this task. Import,
// insert, recovery and the learner hold what comes from outside against them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/config/config.h"
#include "common/step/step_spec.h"
#include "common/util/result.h"

namespace dadrl {

class ChunkView;
class PayloadCodec;

// A lane's limit below it counts as this much in the reward, so that driving over a slow lane's limit costs a
// bounded amount.
constexpr double kSlowestLimit = 1.0;  // m/s

struct ExperienceBounds {
  double reward = 0.0;    // |reward| of a decision
  double horizon = 0.0;   // decisions that count towards a value
  double value = 0.0;     // |discounted sum of rewards| from any state on
  double priority = 0.0;  // of an item: the error between two such values

  // Of the tasks that these weights, speeds, intervals and discount make. Float rounding is allowed for.
  static ExperienceBounds From(const Config& config);
  // Of all tasks that a configuration can make: for experience whose configuration is not at hand.
  static ExperienceBounds OfAnyTask();

  // Not a NaN either.
  bool AllowsReward(float r) const { return std::abs(r) <= reward; }
  bool AllowsPriority(float p) const { return p >= 0.0f && p <= priority; }
};

// Finite, and within the bound of its column.
bool IsPossibleDecision(const StepSpec& spec, std::span<const float> decision);
// kCorrupt names the first frame whose decision is of another length, or beyond its columns' bounds.
Status CheckDecisions(const ChunkView& chunk, const StepSpec& spec);
// kCorrupt names the first frame with another reward, the reward and the bound.
Status CheckRewards(const ChunkView& chunk, const ExperienceBounds& bounds);

}  // namespace dadrl
