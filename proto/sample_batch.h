// A sampled batch on its way from the replay to the learner: n-step slices, frames still compressed.
//
// The replay does not know gamma: it sends the rewards of each slice, and the learner sums them.
//
// Wire format, little endian: magic u32, version u32, schema u64, count u32, total bytes u32 | an entry an
// item: key u64, probability f32, importance weight f32, policy_version u32, action f32[2], steps u16,
// terminated u16, payload lengths u32[2] (the second 0 when terminated) | rewards f32[steps], item by item |
// payloads, item by item | xxh3-64 of everything before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/model/transition_batch.h"
#include "common/util/result.h"
#include "proto/experience.h"
#include "proto/experience_bounds.h"

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

// Longest slice, as algorithm.n_step allows.
constexpr int kMaxSliceSteps = 32;

// What EncodeSampleBatch makes of them.
size_t SampleBatchBytes(std::span<const SampledItem> items);

// Serialises `items`; lengths and an xxh3-64 checksum included. Each item has 1 to kMaxSliceSteps rewards.
// `memory` of an earlier batch is used again.
std::vector<std::byte> EncodeSampleBatch(std::span<const SampledItem> items, uint64_t schema,
                                         std::vector<std::byte> memory = {});

// Parses and decodes into `batch` (its size must match): rewards summed with gamma, discounts gamma^k or 0.
// kCorrupt on anything that does not fit, and on numbers beyond `bounds` (`batch` is then unspecified); never
// reads outside `bytes`. `codec` must be of `schema`'s spec. Takes 5 to 10 us a frame: do it off the training
// thread.
Status DecodeSampleBatch(std::span<const std::byte> bytes, uint64_t schema, double gamma,
                         const ExperienceBounds& bounds, FrameCodec& codec, TransitionBatch& batch);

}  // namespace dadrl
