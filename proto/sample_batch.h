// A sampled batch on its way from the replay to the learner: n-step slices, frames still compressed.
//
// The replay does not know gamma: it sends the rewards of each slice, and the learner sums them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/model/transition_batch.h"
#include "common/util/result.h"
#include "proto/experience.h"

namespace dadrl {

// One sampled slice: frames t .. t + k of an episode, k <= n_step, of which the first and the last are sent.
struct SampledItem {
  uint64_t key = 0;
  float probability = 1.0f;        // of having been drawn
  float importance_weight = 1.0f;  // scaled so that the largest of the batch is 1
  uint32_t policy_version = 0;
  Action action{};
  bool terminated = false;           // the episode ended within the slice: `next` is empty
  std::span<const float> rewards;    // k of them
  std::span<const std::byte> first;  // payload of frame t
  std::span<const std::byte> next;   // payload of frame t + k
};

// Serialises `items`; lengths and an xxh3-64 checksum included.
std::vector<std::byte> EncodeSampleBatch(std::span<const SampledItem> items, uint64_t schema);

// Parses and decodes into `batch` (its size must match): rewards summed with gamma, discounts gamma^k or 0.
// kCorrupt on anything that does not fit; never reads outside `bytes`. `codec` must be of `schema`'s spec.
Status DecodeSampleBatch(std::span<const std::byte> bytes, uint64_t schema, double gamma, FrameCodec& codec,
                         TransitionBatch& batch);

}  // namespace dadrl
