#include "common/config/validate.h"

#include <algorithm>

namespace dadrl {

Status Validate(const Config& config) {
  if (config.algorithm.name != "sac") {
    return Fail(ErrorCode::kInvalidArgument, "algorithm.name: '{}' is unknown; there is: sac",
                config.algorithm.name);
  }
  if (config.algorithm.batch_size % 16 != 0) {
    return Fail(ErrorCode::kInvalidArgument, "algorithm.batch_size: {} is not a multiple of 16",
                config.algorithm.batch_size);
  }
  if (config.algorithm.batch_size < 16 * config.learner.threads) {
    return Fail(ErrorCode::kInvalidArgument,
                "learner.threads: {} threads need algorithm.batch_size of at least {}, it is {}",
                config.learner.threads, 16 * config.learner.threads, config.algorithm.batch_size);
  }
  if (!config.model.stae && !config.model.context) {
    return Fail(ErrorCode::kInvalidArgument, "model.stae and model.context are both false; keep one");
  }
  if (config.replay.segment_bytes > config.replay.max_disk_bytes) {
    return Fail(ErrorCode::kInvalidArgument, "replay.segment_bytes: {} exceeds replay.max_disk_bytes: {}",
                config.replay.segment_bytes, config.replay.max_disk_bytes);
  }
  const ReplayConfig& replay = config.replay;
  if (replay.samples_per_insert > 0.0 && replay.min_samples_per_insert > replay.samples_per_insert) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.min_samples_per_insert: {} exceeds replay.samples_per_insert: {}; both sides would wait",
        replay.min_samples_per_insert, replay.samples_per_insert);
  }
  if (replay.sequence_period > std::max(replay.sequence_length, 1)) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.sequence_period: {} exceeds replay.sequence_length: {}; frames between would never be drawn",
        replay.sequence_period, replay.sequence_length);
  }
  const int64_t shard_min_size = (replay.min_size + replay.shards - 1) / replay.shards;
  if (replay.max_items > 0 && replay.max_items < shard_min_size) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "replay.max_items: {} is less than a shard's part of replay.min_size, {}; nothing would ever be "
        "drawn",
        replay.max_items, shard_min_size);
  }
  const int times = std::max(replay.max_times_sampled, 1);
  const int64_t items_of_a_batch = (config.algorithm.batch_size + times - 1) / times;
  if (replay.max_items > 0 && replay.max_times_sampled > 0 && replay.max_items < items_of_a_batch) {
    return Fail(ErrorCode::kInvalidArgument,
                "replay.max_items: {} items of replay.max_times_sampled: {} never make a batch of "
                "algorithm.batch_size: {}; nothing would ever be drawn",
                replay.max_items, replay.max_times_sampled, config.algorithm.batch_size);
  }
  const bool random = replay.sampler == SamplerKind::kUniform || replay.sampler == SamplerKind::kPrioritized;
  if (!random && replay.max_times_sampled == 0) {
    return Fail(ErrorCode::kInvalidArgument,
                "replay.max_times_sampled: 0 with an ordered replay.sampler draws one item for ever; set it "
                "to at least 1");
  }
  return {};
}

}  // namespace dadrl
