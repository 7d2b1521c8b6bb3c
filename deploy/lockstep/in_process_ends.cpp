#include "deploy/lockstep/in_process_ends.h"

#include <utility>

#include "proto/sample_batch.h"

namespace dadrl {
namespace {

// Chunks of a lockstep training have one writer that never restarts.
constexpr uint64_t kOnlyIncarnation = 1;

}  // namespace

TableSink::TableSink(const Config& config, ReplayTable& table)
    : chunk_frames_(config.actor.chunk_frames),
      table_(table),
      builder_(ObservationSpec::From(config.observation), config.actor.floats) {}

void TableSink::BeginEpisode(uint64_t episode) {
  episode_ = episode;
  next_frame_ = 0;
  builder_.Begin(episode_, next_frame_);
}

void TableSink::AddTransition(const Observation& observation, const Action& action, float reward,
                              uint8_t flags, uint32_t policy_version) {
  builder_.AddTransition(observation, action, reward, flags, policy_version);
  ++next_frame_;
  if (builder_.frames() >= chunk_frames_ || builder_.full()) Flush();
}

void TableSink::AddFinal(const Observation& observation) {
  builder_.AddFinal(observation);
  ++next_frame_;
}

void TableSink::EndEpisode() {
  if (builder_.frames() > 0) Flush();
}

void TableSink::Flush() {
  const std::vector<std::byte> chunk =
      builder_.Finish({.actor = 0, .incarnation = kOnlyIncarnation, .sequence = ++sequence_});
  builder_.Begin(episode_, next_frame_);
  auto inserted = table_.Insert(chunk);
  if (!status_) return;
  if (!inserted) {
    status_ = tl::unexpected<Error>(std::move(inserted.error()));
  } else if (*inserted != ReplayTable::Insertion::kStored) {
    status_ = Fail(ErrorCode::kInternal, "the replay refused chunk {} of episode {}", sequence_, episode_);
  }
}

TableBatchSource::TableBatchSource(const Config& config, ReplayTable& table)
    : algorithm_(config.algorithm),
      bounds_(ExperienceBounds::From(config)),
      table_(table),
      codec_(ObservationSpec::From(config.observation), config.actor.floats),
      batch_(ObservationSpec::From(config.observation), config.algorithm.batch_size) {}

TransitionBatch* TableBatchSource::Take(Duration) {
  if (!status_) return nullptr;
  const auto count = static_cast<size_t>(algorithm_.batch_size);
  if (table_.MaySample(count) != RateLimiter::Hold::kNone) return nullptr;
  status_ = Fill();
  return status_ ? &batch_ : nullptr;
}

Status TableBatchSource::Fill() {
  DADRL_ASSIGN_OR_RETURN(const SampledBatch sampled,
                         table_.Sample(static_cast<size_t>(algorithm_.batch_size), algorithm_.n_step, 0));
  const std::vector<std::byte> bytes = EncodeSampleBatch(sampled.items, table_.schema());
  return DecodeSampleBatch(bytes, table_.schema(), algorithm_.gamma, bounds_, codec_, batch_);
}

void TableBatchSource::Release(TransitionBatch*) {}

void TableBatchSource::UpdatePriorities(const TransitionBatch& batch, std::span<const float> td_error) {
  table_.UpdatePriorities(batch.key, td_error);
}

void PolicyRelay::Publish(const PolicyUpdate& update) {
  version_ = update.version;
  parameters_.assign(update.parameters.begin(), update.parameters.end());
}

uint32_t PolicyRelay::TakeNewer(uint32_t have, std::vector<float>& parameters) {
  if (version_ <= have) return 0;
  parameters = parameters_;
  return version_;
}

}  // namespace dadrl
