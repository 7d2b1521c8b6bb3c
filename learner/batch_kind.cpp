#include "learner/batch_kind.h"

#include "proto/sample_batch.h"
#include "proto/sequence_batch.h"

namespace dadrl {

Status BatchKind<TransitionBatch>::Check(const Config& config) {
  if (config.replay.sequence_period == 1) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "replay.sequence_period: {} lets only every {}th frame be drawn, and this learner trains on "
              "transitions; set it to 1",
              config.replay.sequence_period, config.replay.sequence_period);
}

TransitionBatch BatchKind<TransitionBatch>::Make(const Config& config) {
  return {ObservationSpec::From(config.observation), config.algorithm.batch_size};
}

void BatchKind<TransitionBatch>::Describe(const Config& config, dadrl_idl_BatchRequest& request) {
  request.batch_size = static_cast<uint32_t>(config.algorithm.batch_size);
  request.n_step = static_cast<uint32_t>(config.algorithm.n_step);
}

Status BatchKind<TransitionBatch>::Decode(std::span<const std::byte> bytes, uint64_t schema,
                                          const Config& config, FrameCodec& codec, TransitionBatch& batch) {
  return DecodeSampleBatch(bytes, schema, config.algorithm.gamma, ExperienceBounds::From(config), codec,
                           batch);
}

Status BatchKind<SequenceBatch>::Check(const Config& config) {
  if (config.replay.sequence_length > 0) return {};
  return Fail(ErrorCode::kInvalidArgument,
              "replay.sequence_length: 0 makes no sequences, and this learner trains on them; set it to "
              "their decisions, 1 to {}",
              kMaxSequenceLength);
}

SequenceBatch BatchKind<SequenceBatch>::Make(const Config& config) {
  return {ObservationSpec::From(config.observation), config.algorithm.batch_size,
          config.replay.sequence_length};
}

void BatchKind<SequenceBatch>::Describe(const Config& config, dadrl_idl_BatchRequest& request) {
  request.batch_size = static_cast<uint32_t>(config.algorithm.batch_size);
  request.sequence_length = static_cast<uint32_t>(config.replay.sequence_length);
}

Status BatchKind<SequenceBatch>::Decode(std::span<const std::byte> bytes, uint64_t schema,
                                        const Config& config, FrameCodec& codec, SequenceBatch& batch) {
  return DecodeSequenceBatch(bytes, schema, ExperienceBounds::From(config), codec, batch);
}

}  // namespace dadrl
