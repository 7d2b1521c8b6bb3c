// Training without concurrency: actor, replay and learner take turns inside one process, so that the same
// configuration gives the same weights, bit for bit. The parts are those of the cluster; only what lies
// between them (DDS, threads, the wall clock) is memory, turns and a clock that only updates move.
//
// The one place that links all three roles (the design's exception to its own folder order).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

// Seconds of the lockstep clock that one training update takes: intervals in seconds (publication,
// checkpoints, minutes) are counted in it.
constexpr double kLockstepUpdateSeconds = 0.05;

struct LockstepResult {
  uint64_t updates = 0;
  uint64_t episodes = 0;
  uint64_t decisions = 0;
  uint64_t policy_hash = 0;  // xxh3-64 of the published policy's parameters
};

// Trains until learner.max_updates, `minutes` of the lockstep clock, or `stop`; one of the first two must be
// set (kInvalidArgument). After each episode come as many updates as keep replay.samples_per_insert. Writes
// checkpoints into <run_directory>/checkpoints, which must hold none (kInvalidArgument).
Result<LockstepResult> TrainInLockstep(const Config& config, const std::filesystem::path& run_directory,
                                       const std::atomic<bool>& stop);

}  // namespace dadrl
