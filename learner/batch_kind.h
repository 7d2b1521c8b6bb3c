// What a fetcher must know of a kind of batch: n-step transitions, or sequences for recurrent algorithms.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "common/config/config.h"
#include "common/model/sequence_batch.h"
#include "common/model/transition_batch.h"
#include "common/util/result.h"
#include "proto/experience.h"
#include "proto/topics.h"

namespace dadrl {

// Both have algorithm.batch_size entries.
template <typename Batch>
struct BatchKind;

template <>
struct BatchKind<TransitionBatch> {
  // kInvalidArgument: replays of this configuration do not serve the kind as they should.
  static Status Check(const Config& config);
  static TransitionBatch Make(const Config& config);
  // Says in `request` what is asked for.
  static void Describe(const Config& config, dadrl_idl_BatchRequest& request);
  // kCorrupt: `bytes` are no such batch, or hold what the task of `config` cannot produce.
  static Status Decode(std::span<const std::byte> bytes, uint64_t schema, const Config& config,
                       FrameCodec& codec, TransitionBatch& batch);
};

template <>
struct BatchKind<SequenceBatch> {
  static Status Check(const Config& config);
  static SequenceBatch Make(const Config& config);
  static void Describe(const Config& config, dadrl_idl_BatchRequest& request);
  static Status Decode(std::span<const std::byte> bytes, uint64_t schema, const Config& config,
                       FrameCodec& codec, SequenceBatch& batch);
};

}  // namespace dadrl
