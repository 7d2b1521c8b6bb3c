// Rows of the two tables of training episodes: an actor's own (logs/episodes-actor-N.csv), with all metrics,
// and the run's (episodes.csv), which is made of the actors'.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "proto/evaluation/episode_summary.h"

namespace dadrl {

// The header of either table, without its line break.
const std::string& ActorEpisodeColumns();
const std::string& RunEpisodeColumns();

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
