// Rows of the two tables of training episodes: an actor's own (logs/episodes-actor-N.csv), with all metrics,
// and the run's (episodes.csv), which is made of the actors'.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/evaluation/episode_summary.h"

namespace dadrl {

inline constexpr std::string_view kActorEpisodeColumns =
    "time_s,incarnation,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,"
    "obstacle_cost,jerk_cost,lane_offset_cost,rule_violation,distance_to_destination,time_cost,overall_score,"
    "policy_version,scenario";
inline constexpr std::string_view kRunEpisodeColumns =
    "time_s,actor,episode,seed,outcome,steps,return,progress,mean_speed_mps,humanness_error,overall_score,"
    "policy_version,scenario";

struct TrainingEpisode {
  int64_t wall_time_ns = 0;  // of its end
  uint64_t incarnation = 0;
  uint64_t episode = 0;  // of its actor, over all its incarnations
  uint32_t policy_version = 0;
  EpisodeSummary summary;
};

// A row of the actor's table, with its line break.
std::string ActorEpisodeRow(const TrainingEpisode& episode);

// What counts and orders a row of either table.
struct EpisodeKey {
  double time_s = 0.0;
  uint64_t episode = 0;
  uint64_t steps = 0;  // simulation steps
};
// Of a row without its line break; nothing when it is no row of such a table.
std::optional<EpisodeKey> ActorEpisodeKey(std::string_view row);
// The same of the run's table; `actor`: whose row it is.
std::optional<EpisodeKey> RunEpisodeKey(std::string_view row, int& actor);

// The run's row, with its line break, made of a row that has an ActorEpisodeKey.
std::string RunEpisodeRow(int actor, std::string_view actor_row);

}  // namespace dadrl
