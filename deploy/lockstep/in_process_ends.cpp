#include "deploy/lockstep/in_process_ends.h"

#include <utility>

namespace dadrl {
namespace {

// Chunks of a lockstep training have one writer that never restarts.
constexpr uint64_t kOnlyIncarnation = 1;

}  // namespace

TableSink::TableSink(const Config& config, ReplayTable& table)
    : ChunkingSink(config, 0, kOnlyIncarnation), table_(table) {}

void TableSink::OnChunk(uint64_t sequence, std::vector<std::byte> bytes) {
  auto inserted = table_.Insert(bytes);
  if (!status_) return;
  if (!inserted) {
    status_ = tl::unexpected<Error>(std::move(inserted.error()));
  } else if (*inserted != ReplayTable::Insertion::kStored) {
    status_ = Fail(ErrorCode::kInternal, "the replay refused chunk {}", sequence);
  }
}

TableBatchSource::TableBatchSource(const Config& config, const TrajectoryShape& shape, ReplayTable& table)
    : table_(table),
      decoder_(DrivingStepSpec(config), ExperienceBounds::From(config)),
      batch_(DrivingStepSpec(config), shape) {}

TrajectoryBatch* TableBatchSource::Take(Duration) {
  if (!status_) return nullptr;
  if (table_.MaySample(batch_.shape) != RateLimiter::Hold::kNone) return nullptr;
  status_ = Fill();
  return status_ ? &batch_ : nullptr;
}

Status TableBatchSource::Fill() {
  DADRL_ASSIGN_OR_RETURN(const SampledBatch sampled, table_.Sample(batch_.shape, 0));
  return decoder_.Decode(EncodeTrajectories(sampled.trajectories, batch_.shape, table_.schema()), batch_);
}

void TableBatchSource::Release(TrajectoryBatch*) {}

void TableBatchSource::UpdatePriorities(const TrajectoryBatch& batch, std::span<const float> td_error) {
  table_.UpdatePriorities(batch.keys, td_error);
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
