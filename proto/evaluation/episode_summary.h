// How an episode ended and how it was driven: one row of episodes.csv, one sample of an evaluation.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/evaluation/collision_summary.h"

namespace dadrl {

// The integers travel in telemetry: append only.
enum class Outcome { kSuccess, kCollision, kOffRoad, kStagnation };
constexpr size_t kOutcomes = 4;

// "success", "collision", "off_road", "stagnation".
std::string_view OutcomeName(Outcome outcome);
std::optional<Outcome> OutcomeFromName(std::string_view name);

// What is measured of an episode; names in JSON and CSV: summary_fields.h.
struct EpisodeMeasures {
  double episode_return = 0.0;  // undiscounted sum of rewards
  double progress = 0.0;        // fraction of the route driven
  double mean_speed_mps = 0.0;
  // Each in [0, 1]; defined in actor/task/metrics.h.
  double humanness_error = 0.0;
  double obstacle_cost = 0.0;
  double jerk_cost = 0.0;
  double lane_offset_cost = 0.0;
  double rule_violation = 0.0;
  double distance_to_destination = 0.0;
  double time_cost = 0.0;
  double overall_score = 0.0;

  bool operator==(const EpisodeMeasures&) const = default;
};

struct EpisodeSummary : EpisodeMeasures {
  std::string scenario;
  uint64_t seed = 0;
  Outcome outcome = Outcome::kStagnation;
  int steps = 0;                              // simulation steps of 0.1 s
  std::optional<CollisionSummary> collision;  // of an episode that ended in one

  bool operator==(const EpisodeSummary&) const = default;
};

}  // namespace dadrl
