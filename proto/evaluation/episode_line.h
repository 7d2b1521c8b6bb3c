// One episode of an evaluation as a line of JSON: how an evaluating process hands its results to whoever
// gathers them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/result.h"
#include "proto/evaluation/episode_summary.h"

namespace dadrl {

// Which episode to drive: traffic seed `seed` of seed group `group`.
struct PlannedEpisode {
  int group = 0;
  uint64_t seed = 0;
  bool operator==(const PlannedEpisode&) const = default;
};

// A seed group's traffic seeds are kSeedGroupStride apart from the next group's.
constexpr uint64_t kSeedGroupStride = 1000;
// Evaluation draws traffic from here up; training draws below.
constexpr uint64_t kFirstEvaluationSeed = 1'000'000;
// Evaluations while training, and the choice among its last policies, draw from here up: what is chosen on
// traffic is not graded on it. A thousand seed groups from kFirstEvaluationSeed end below.
constexpr uint64_t kFirstValidationSeed = 2'000'000;

// `groups` times `episodes`: group i has the seeds first_seed + 1000 i + j for j < episodes.
// kInvalidArgument: first_seed below kFirstEvaluationSeed, episodes outside [1, 1000] (groups would overlap),
// groups below 1.
Result<std::vector<PlannedEpisode>> PlanEpisodes(uint64_t first_seed, int groups, int episodes);

// The episodes of one of `workers` processes: every workers-th, so that all finish at about the same time.
std::vector<PlannedEpisode> EpisodesOfWorker(const std::vector<PlannedEpisode>& plan, int worker,
                                             int workers);

// An episode that was driven, or that was lost to the simulator (then `error` says how, and of `summary` only
// the seed counts).
struct EvaluatedEpisode {
  int group = 0;
  EpisodeSummary summary;
  std::string error;
  bool lost() const { return !error.empty(); }
  bool operator==(const EvaluatedEpisode&) const = default;
};

// No such line is longer, nor one of a rendered episode; nor is a scenario's or an outcome's name.
constexpr size_t kMaxEpisodeLine = size_t{1} << 16;
constexpr size_t kMaxName = 255;
constexpr int kMaxSeedGroups = 1'000'000;

// Without a line break. Round-trips exactly.
std::string EpisodeLine(const EvaluatedEpisode& episode);
// kCorrupt: not such a line; names the field that is wrong. Every number is finite and within 1e9.
Result<EvaluatedEpisode> ParseEpisodeLine(std::string_view line);

}  // namespace dadrl
