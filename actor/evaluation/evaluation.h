// Drives a list of episodes with a policy and reports each.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "actor/policies/driving_policy.h"
#include "common/config/config.h"
#include "common/util/result.h"
#include "proto/evaluation/report.h"

namespace dadrl {

// Called after each episode, on the calling thread; may be empty. False stops the evaluation.
using OnEpisode = std::function<bool(const EvaluatedEpisode&)>;

struct EvaluationOptions {
  Config config;       // scenario, traffic, task; a learned policy brings its own observation and model
  std::string policy;  // as MakePolicy's name
  PolicyOptions policy_options;
  std::vector<PlannedEpisode> episodes;
  OnEpisode on_episode;
};

// Drives the episodes in order in this process, which must not have an environment yet. An episode that the
// simulator loses is reported as lost, and the next one starts clean.
// kInvalidArgument: unknown scenario or policy. kInternal: every episode was lost.
Result<EvaluationReport> RunEvaluation(const EvaluationOptions& options);

// The same with an environment and a policy at hand.
std::vector<EvaluatedEpisode> DriveEpisodes(DrivingEnvironment& environment, DrivingPolicy& policy,
                                            const std::vector<PlannedEpisode>& plan,
                                            const OnEpisode& on_episode);

// Drives one episode. Errors as Environment.
Result<EpisodeSummary> DriveEpisode(DrivingEnvironment& environment, DrivingPolicy& policy, uint64_t seed);

// Prints `line` and a line break on standard output and flushes: the line protocol between `dadrl-actor` and
// the process that gathers. Returns false when nobody reads any more.
bool PrintLine(std::string line);

}  // namespace dadrl
