// The processes of a local cluster: their command lines, logs and how they are stopped.
#pragma once

#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/local/run_directory.h"
#include "deploy/local/supervisor.h"

namespace dadrl {

inline constexpr const char* kReplayRole = "replay";
inline constexpr const char* kLearnerRole = "learner";
inline constexpr const char* kActorRole = "actor";

// Replay shards, learner and actors of the run, in the order they are started. The configuration must have
// been saved to the run directory. kNotFound when a program is missing.
Result<std::vector<ProcessSpec>> ClusterProcesses(const RunPaths& paths, const Config& config);

// Whose numbers actors have.
enum class ActorNumbers {
  kOwn,    // the ones asked for, or none
  kGiven,  // any that the run gives out; `first` only begins the names of processes and files
};
// Actors `first` to `first + count - 1`.
Result<std::vector<ProcessSpec>> ActorProcesses(const RunPaths& paths, int first, int count,
                                                ActorNumbers numbers = ActorNumbers::kOwn);

}  // namespace dadrl
