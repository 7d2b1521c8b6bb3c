// Decodes frames of new chunks: what a checksum cannot tell is whether its writer was sane.
#pragma once

#include <cstdint>
#include <unordered_map>

#include "common/step/columns.h"
#include "common/util/random.h"
#include "common/util/result.h"
#include "proto/experience.h"

namespace dadrl {

// A faulty writer is seldom faulty once, so trust is earned: every frame of an incarnation's first
// kProbation chunks is decoded, afterwards one of each chunk, at random; a chunk that fails starts the
// probation again. What slips through is refused by the learner, which decodes all it receives. Not thread
// safe.
class ChunkVerifier {
 public:
  static constexpr int kProbation = 64;

  // `all`: every frame of every chunk, always.
  ChunkVerifier(const StepSpec& spec, bool all, uint64_t seed)
      : codec_(spec, FloatCoding::kFloat16), row_(spec, 1), all_(all), random_(seed) {}

  // kCorrupt with the actor, the frame and what is wrong with it. Takes about 2 us for each frame it decodes.
  Status Check(const ChunkView& chunk);

 private:
  struct Trust {
    uint64_t incarnation = 0;
    int sound_chunks = 0;  // in a row, up to kProbation
  };
  Status CheckFrame(const ChunkView& chunk, int frame);

  PayloadCodec codec_;
  Columns row_;
  const bool all_;
  Random random_;
  std::unordered_map<uint32_t, Trust> trust_;  // by actor; bounded by the table's number of actors
};

}  // namespace dadrl
