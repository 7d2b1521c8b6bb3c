// The fields of EpisodeMeasures with their names in JSON and CSV: every list of them is made from this one.
#pragma once

#include <array>

#include "proto/evaluation/episode_summary.h"

namespace dadrl {

struct SummaryField {
  const char* name;
  double EpisodeMeasures::*value;
  bool in_run_table = false;  // episodes.csv has it, not only the actor's own table
};

constexpr std::array<SummaryField, 11> kSummaryFields = {{
    {"return", &EpisodeMeasures::episode_return, true},
    {"progress", &EpisodeMeasures::progress, true},
    {"mean_speed_mps", &EpisodeMeasures::mean_speed_mps, true},
    {"humanness_error", &EpisodeMeasures::humanness_error, true},
    {"obstacle_cost", &EpisodeMeasures::obstacle_cost},
    {"jerk_cost", &EpisodeMeasures::jerk_cost},
    {"lane_offset_cost", &EpisodeMeasures::lane_offset_cost},
    {"rule_violation", &EpisodeMeasures::rule_violation},
    {"distance_to_destination", &EpisodeMeasures::distance_to_destination},
    {"time_cost", &EpisodeMeasures::time_cost},
    {"overall_score", &EpisodeMeasures::overall_score, true},
}};

}  // namespace dadrl
