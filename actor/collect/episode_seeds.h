// Which traffic an actor trains on.
#pragma once

#include <cstdint>

namespace dadrl {

// Traffic seed of `episode` (1, 2, 3, ...) of an actor: below kFirstEvaluationSeed, different between the
// actors of a run and between the incarnations of an actor, so that a restarted one does not drive the same
// traffic again.
uint64_t TrainingSeed(uint64_t run_seed, uint32_t actor, uint64_t incarnation, uint64_t episode);

// Seed of the actor's own draws (exploration) in this incarnation.
uint64_t ActionSeed(uint64_t run_seed, uint32_t actor, uint64_t incarnation);

}  // namespace dadrl
