// What a training update consumes: n-step transitions, ready to use.
#pragma once

#include <cstdint>
#include <vector>

#include "common/model/observation.h"

namespace dadrl {

struct TransitionBatch {
  int size = 0;
  ObservationBatch observation;  // at t
  ObservationBatch
      next_observation;         // at t + k, k <= n; all zero where the episode terminated (discount is 0)
  std::vector<float> action;    // [size, 2], at t
  std::vector<float> reward;    // [size], sum over i < k of gamma^i r_(t+i)
  std::vector<float> discount;  // [size], gamma^k, or 0 where the episode terminated within the k steps
  std::vector<float> weight;    // [size], importance weights, 1 for uniform replay
  std::vector<uint64_t> key;    // [size], replay keys, for priorities
  std::vector<uint32_t> policy_version;  // [size], of the policy that acted at t

  TransitionBatch(const ObservationSpec& spec, int batch_size)
      : size(batch_size),
        observation(spec, batch_size),
        next_observation(spec, batch_size),
        action(static_cast<size_t>(batch_size * kActionSize)),
        reward(static_cast<size_t>(batch_size)),
        discount(static_cast<size_t>(batch_size)),
        weight(static_cast<size_t>(batch_size), 1.0f),
        key(static_cast<size_t>(batch_size)),
        policy_version(static_cast<size_t>(batch_size)) {}
};

}  // namespace dadrl
