// The measured fields of an EpisodeSummary with their names in JSON and CSV.
#pragma once

#include <array>

#include "proto/evaluation/episode_summary.h"

namespace dadrl {

struct SummaryField {
  const char* name;
  double EpisodeSummary::*value;
};

constexpr std::array<SummaryField, 11> kSummaryFields = {{
    {"return", &EpisodeSummary::episode_return},
    {"progress", &EpisodeSummary::progress},
    {"mean_speed_mps", &EpisodeSummary::mean_speed_mps},
    {"humanness_error", &EpisodeSummary::humanness_error},
    {"obstacle_cost", &EpisodeSummary::obstacle_cost},
    {"jerk_cost", &EpisodeSummary::jerk_cost},
    {"lane_offset_cost", &EpisodeSummary::lane_offset_cost},
    {"rule_violation", &EpisodeSummary::rule_violation},
    {"distance_to_destination", &EpisodeSummary::distance_to_destination},
    {"time_cost", &EpisodeSummary::time_cost},
    {"overall_score", &EpisodeSummary::overall_score},
}};

}  // namespace dadrl
