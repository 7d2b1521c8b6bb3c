#include "actor/collect/episode_seeds.h"

#include "common/util/random.h"
#include "proto/evaluation/episode_line.h"

namespace dadrl {
namespace {

enum Stream : uint64_t { kTraffic, kActions };

uint64_t IncarnationSeed(uint64_t run_seed, uint32_t actor, uint64_t incarnation, Stream stream) {
  return DeriveSeed(DeriveSeed(DeriveSeed(run_seed, actor), incarnation), stream);
}

}  // namespace

uint64_t TrainingSeed(uint64_t run_seed, uint32_t actor, uint64_t incarnation, uint64_t episode) {
  return DeriveSeed(IncarnationSeed(run_seed, actor, incarnation, kTraffic), episode) % kFirstEvaluationSeed;
}

uint64_t ActionSeed(uint64_t run_seed, uint32_t actor, uint64_t incarnation) {
  return IncarnationSeed(run_seed, actor, incarnation, kActions);
}

}  // namespace dadrl
