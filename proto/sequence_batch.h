// Sequences as the replay serves them to a recurrent learner: stretches of an episode whose frames it has not
// decoded.
//
// Wire format, little endian: magic u32, version u32, schema u64, count u32, length u32 | per sequence: key
// u64, probability f32, weight f32, steps u16, ends u16 | per sequence and step: policy_version u32, action
// f32[2], reward f32 | per sequence and frame: payload bytes u32 | payloads | xxh3-64 of everything before.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/model/sequence_batch.h"
#include "common/util/result.h"
#include "proto/experience.h"
#include "proto/experience_bounds.h"

namespace dadrl {

// The longest, as replay.sequence_length allows.
constexpr int kMaxSequenceLength = 256;

struct SequenceStep {
  uint32_t policy_version = 0;
  Action action{};
  float reward = 0.0f;
};

// One sequence as drawn; borrows what it points to until it is sent.
struct SampledSequence {
  uint64_t key = 0;
  float probability = 1.0f;
  float importance_weight = 1.0f;
  bool terminated = false;  // at its last step; then there is no frame behind it
  bool truncated = false;
  std::vector<SequenceStep> steps;
  std::vector<std::span<const std::byte>> frames;  // payloads: as many as steps, and the one behind them
};

// What EncodeSequenceBatch makes of them.
size_t SequenceBatchBytes(std::span<const SampledSequence> sequences);

// Serialises `sequences` of at most `length` steps.
std::vector<std::byte> EncodeSequenceBatch(std::span<const SampledSequence> sequences, int length,
                                           uint64_t schema);

// Parses and decodes into `batch`, whose size and length must match. Errors, bounds and threads as
// DecodeSampleBatch.
Status DecodeSequenceBatch(std::span<const std::byte> bytes, uint64_t schema, const ExperienceBounds& bounds,
                           FrameCodec& codec, SequenceBatch& batch);

}  // namespace dadrl
