// What a recurrent algorithm trains on: stretches of episodes.
#pragma once

#include <cstdint>
#include <vector>

#include "common/model/observation.h"

namespace dadrl {

// Sequence i has steps[i] decisions, at most `length`: fewer where its episode ended. What lies behind them
// is zero. An end is in a sequence at most as its last step.
struct SequenceBatch {
  int size = 0;
  int length = 0;
  // Row i * (length + 1) + t is the observation before decision t; the one behind the last decision follows
  // it, unless the episode terminated there.
  ObservationBatch observation;
  std::vector<float> action;             // [size, length, 2]
  std::vector<float> reward;             // [size, length]
  std::vector<uint32_t> policy_version;  // [size, length], of the policy that acted
  std::vector<int> steps;                // [size]
  std::vector<uint8_t> terminated;       // [size]: nothing follows; do not bootstrap
  std::vector<uint8_t> truncated;        // [size]: the time limit; bootstrap from the last observation
  std::vector<float> weight;             // [size], importance weights, 1 for uniform replay
  std::vector<uint64_t> key;             // [size], replay keys, for priorities

  SequenceBatch(const ObservationSpec& spec, int batch_size, int sequence_length)
      : size(batch_size),
        length(sequence_length),
        observation(spec, batch_size * (sequence_length + 1)),
        action(static_cast<size_t>(batch_size * sequence_length * kActionSize)),
        reward(static_cast<size_t>(batch_size * sequence_length)),
        policy_version(static_cast<size_t>(batch_size * sequence_length)),
        steps(static_cast<size_t>(batch_size)),
        terminated(static_cast<size_t>(batch_size)),
        truncated(static_cast<size_t>(batch_size)),
        weight(static_cast<size_t>(batch_size), 1.0f),
        key(static_cast<size_t>(batch_size)) {}
};

}  // namespace dadrl
