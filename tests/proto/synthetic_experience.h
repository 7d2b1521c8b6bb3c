// Experience as an actor would send it, without a simulator: a T junction seen from a moving ego, vehicles on
// its arms. The shapes, scales and regularity of the real thing, from a seed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/step/driving_shape.h"
#include "common/util/random.h"
#include "proto/experience.h"

namespace dadrl {

// One observation somewhere on the way through the junction.
Observation SyntheticObservation(const DrivingShape& spec, Random& random);

// An observation without any regularity: random bits, random finite floats of all sizes.
Observation NoiseObservation(const DrivingShape& spec, Random& random);

struct SyntheticChunk {
  ChunkIdentity identity;
  uint64_t episode = 1;
  uint32_t first_frame = 0;
  int frames = 64;           // with an action
  uint8_t end = 0;           // kTerminated or kTruncated on the last of them
  bool final_frame = false;  // the observation after a truncation follows
  uint32_t policy_version = 1;
  FloatCoding floats = FloatCoding::kFloat16;
};

// Its bytes. Frame f of episode e has reward (e + f / 1000) / 1024 and action (f / 1000, -f / 1000), so that
// a test can tell which frames it got.
std::vector<std::byte> MakeSyntheticChunk(const DrivingShape& spec, const SyntheticChunk& chunk,
                                          uint64_t seed = 1);

}  // namespace dadrl
