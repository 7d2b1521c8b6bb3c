#include "replay/table.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/util/log.h"

namespace dadrl {
namespace {

// Dropping the oldest segment must not drop most of what is there.
constexpr int64_t kLeastSegments = 4;
// Each is a memory mapping, of which Linux allows a process 65,530 (vm.max_map_count).
constexpr int64_t kMostSegments = 16384;

ChunkIndex::Options IndexOptions(const TableOptions& options) {
  const ReplayConfig& replay = options.replay;
  return {.n_step = std::max(options.n_step, replay.sequence_length),
          .stride = static_cast<uint32_t>(replay.sequence_length > 0 ? replay.sequence_period : 1),
          .sampler = options.replay.sampler,
          .priority_exponent = options.replay.priority_exponent,
          .importance_exponent = options.replay.importance_exponent,
          .max_times_sampled = static_cast<uint32_t>(options.replay.max_times_sampled),
          .max_staleness = static_cast<uint32_t>(options.replay.max_staleness),
          .max_items = static_cast<size_t>(options.replay.max_items),
          .remover = options.replay.remover};
}

// What a batch of this shape takes from the limiter.
int64_t Samples(const TrajectoryShape& shape) {
  return int64_t{shape.count} * (shape.all_observations ? shape.steps : 1);
}

int64_t Decisions(const ChunkView& chunk) {
  // Only the last frame may have none.
  const bool final_frame = (chunk.flags(chunk.frames() - 1) & kHasDecision) == 0;
  return chunk.frames() - (final_frame ? 1 : 0);
}

}  // namespace

uint64_t SegmentBytes(const ReplayConfig& replay) {
  return static_cast<uint64_t>(std::clamp(replay.segment_bytes, replay.max_disk_bytes / kMostSegments,
                                          replay.max_disk_bytes / kLeastSegments));
}

RateLimiter::Options LimiterOptions(const ReplayConfig& replay) {
  // Actors are spread evenly, so each shard has its part of it.
  const int64_t min_size = (replay.min_size + replay.shards - 1) / replay.shards;
  return {.min_size = min_size,
          .max_samples_per_insert = replay.samples_per_insert,
          .min_samples_per_insert = replay.min_samples_per_insert,
          .band = std::max(1.0, replay.samples_per_insert_band * min_size)};
}

ReplayTable::ReplayTable(TableOptions options, const Clock& clock)
    : options_(std::move(options)),
      schema_(SchemaHash(options_.spec)),
      clock_(clock),
      index_(IndexOptions(options_)),
      limiter_(LimiterOptions(options_.replay)),
      random_(options_.seed) {}

Result<std::unique_ptr<ReplayTable>> ReplayTable::Open(TableOptions options, const Clock& clock) {
  std::unique_ptr<ReplayTable> table(new ReplayTable(std::move(options), clock));
  DADRL_RETURN_IF_ERROR(table->Recover());
  return table;
}

ReplayTable::Insertion ReplayTable::Refuse(ChunkFault fault, const Error& reason, ChunkRefusal* refusal) {
  if (refusal != nullptr) *refusal = {fault, reason.message};
  MutexLock lock(mutex_);
  if (counters_.rejected_chunks[fault]++ == 0) {
    spdlog::warn("refused a chunk (more like it are counted): {}", reason.message);
  }
  return Insertion::kRejected;
}

Result<ReplayTable::Insertion> ReplayTable::Insert(std::span<const std::byte> bytes, uint64_t oldest_kept,
                                                   ChunkRefusal* refusal) {
  ChunkFault fault{};
  const Result<ChunkView> chunk = ChunkView::Parse(bytes, &fault);
  if (!chunk) return Refuse(fault, chunk.error(), refusal);
  MutexLock inserting(insert_mutex_);
  return InsertParsed(*chunk, oldest_kept, refusal);
}

Result<ReplayTable::Insertion> ReplayTable::InsertParsed(const ChunkView& chunk, uint64_t oldest_kept,
                                                         ChunkRefusal* refusal) {
  const ChunkHeader header = chunk.header();
  const ChunkIdentity& identity = header.identity;
  if (header.schema != schema_) {
    SettleNext(identity, oldest_kept);
    return Refuse(
        ChunkFault::kSchema,
        {ErrorCode::kCorrupt,
         fmt::format("actor {}: its experience has schema {:#x}, this replay holds {:#x}; start the "
                     "actor with the configuration of the run",
                     identity.actor, header.schema, schema_)},
        refusal);
  }
  const auto verdict = sequences_.Check(identity, std::min(oldest_kept, identity.sequence));
  if (verdict != SequenceTable::Verdict::kNext) return Decline(verdict, identity, refusal);
  if (const Status sound = CheckContents(chunk); !sound) {
    sequences_.Accept(identity);
    return Refuse(ChunkFault::kContents, sound.error(), refusal);
  }
  DADRL_RETURN_IF_ERROR(Store(chunk));
  return Insertion::kStored;
}

ReplayTable::Insertion ReplayTable::Decline(SequenceTable::Verdict verdict, const ChunkIdentity& identity,
                                            ChunkRefusal* refusal) {
  switch (verdict) {
    case SequenceTable::Verdict::kNext:
    case SequenceTable::Verdict::kDuplicate: {
      MutexLock lock(mutex_);
      ++counters_.duplicate_chunks;
      return Insertion::kDuplicate;
    }
    case SequenceTable::Verdict::kGap:
      return Insertion::kEarly;
    case SequenceTable::Verdict::kImpossible:
      return Refuse(
          ChunkFault::kContents,
          {ErrorCode::kCorrupt, fmt::format("actor {}: its chunk {} is beyond the last possible one, {}",
                                            identity.actor, identity.sequence, SequenceTable::kMaxSequence)},
          refusal);
    case SequenceTable::Verdict::kStale:
    case SequenceTable::Verdict::kTooMany:
      break;
  }
  return Refuse(ChunkFault::kStale, StaleError(identity), refusal);
}

Error ReplayTable::StaleError(const ChunkIdentity& identity) const {
  const auto newest = sequences_.Newest(identity.actor);
  if (newest) {
    return {ErrorCode::kExhausted, fmt::format("actor {}: its incarnation {} has been followed by {}",
                                               identity.actor, identity.incarnation, newest->incarnation)};
  }
  return {ErrorCode::kExhausted,
          fmt::format("actor {}: this replay has known {} actors, and remembers no more", identity.actor,
                      SequenceTable::kMaxActors)};
}

void ReplayTable::Settle(const ChunkIdentity& identity, uint64_t oldest_kept) {
  MutexLock inserting(insert_mutex_);
  SettleNext(identity, oldest_kept);
}

void ReplayTable::SettleNext(const ChunkIdentity& identity, uint64_t oldest_kept) {
  const auto verdict = sequences_.Check(identity, std::min(oldest_kept, identity.sequence));
  if (verdict != SequenceTable::Verdict::kNext) return;
  const uint64_t skipped = sequences_.Accept(identity);
  MutexLock lock(mutex_);
  counters_.lost_chunks += skipped;
}

Status ReplayTable::CheckContents(const ChunkView& chunk) const {
  DADRL_RETURN_IF_ERROR(CheckRewards(chunk, options_.bounds));
  DADRL_RETURN_IF_ERROR(CheckDecisions(chunk, options_.spec));
  return options_.verify ? options_.verify(chunk) : Status();
}

Status ReplayTable::Store(ChunkView chunk) {
  const size_t length = chunk.bytes().size();
  DADRL_RETURN_IF_ERROR(EnsureSegment(length));
  DADRL_ASSIGN_OR_RETURN(const SegmentLog::Stored stored, log_->Append(chunk.bytes()));
  chunk.Rebase(stored.bytes);
  end_ = {stored.segment->id(), stored.segment->bytes()};
  const uint64_t skipped = sequences_.Accept(chunk.header().identity);
  {
    MutexLock lock(mutex_);
    index_.Add(stored.segment, chunk);
    index_.RemoveSurplus(random_);
    limiter_.OnInsert(Decisions(chunk));
    counters_.inserted_bytes += length;
    counters_.lost_chunks += skipped;
  }
  BoundIndex();
  return {};
}

Status ReplayTable::EnsureSegment(size_t length) {
  if (!log_->NeedsSegment(length)) return {};
  const TimePoint begin = clock_.Now();
  Status rolled = RollSegment(length);
  MutexLock lock(mutex_);
  ++counters_.for_disk.count;
  counters_.for_disk.seconds += ToSeconds(clock_.Now() - begin);
  return rolled;
}

Status ReplayTable::RollSegment(size_t length) {
  const uint64_t next = log_->NextSegmentBytes(length);
  const auto max_disk = static_cast<uint64_t>(options_.replay.max_disk_bytes);
  if (next > max_disk) {
    return Fail(ErrorCode::kExhausted, "a chunk of {} bytes does not fit into replay.max_disk_bytes of {}",
                length, max_disk);
  }
  log_->CloseSegment();
  new_segment_.store(true);
  // The disk is slower than the inserts: they wait, so that replay.sync_interval_s holds.
  const bool sync = options_.replay.sync != SyncMode::kNone;
  if (sync && log_->unforced() > kMaxUnforced) DADRL_RETURN_IF_ERROR(log_->Sync());
  while (log_->segments() > 0 && log_->bytes() + next > max_disk) {
    DADRL_RETURN_IF_ERROR(DropOldestSegment());
  }
  return log_->StartSegment(length);
}

Status ReplayTable::DropOldestSegment() {
  // Afterwards only the state file knows what was stored.
  const bool saved = options_.directory.empty() || log_->oldest_id() < saved_segment_.load();
  if (!saved) DADRL_RETURN_IF_ERROR(ForceAndWriteState(TakeCapture()));
  log_->RemoveOldest();
  const uint64_t oldest = log_->oldest_id();
  MutexLock lock(mutex_);
  index_.DropSegmentsBefore(oldest);
  if (index_.items() > 0 || limiter_.state().sampled > 0 || std::exchange(too_small_reported_, true))
    return {};
  spdlog::warn(
      "the oldest frames leave before any could be sampled: replay.max_disk_bytes {} and "
      "replay.max_memory_bytes {} keep {} frames, and each waits for {} decisions of its episode to follow; "
      "raise them, or lower replay.sequence_length or algorithm.n_step",
      options_.replay.max_disk_bytes, options_.replay.max_memory_bytes, index_.frames(),
      IndexOptions(options_).n_step);
  return {};
}

void ReplayTable::BoundIndex() {
  const auto max_memory = static_cast<size_t>(options_.replay.max_memory_bytes);
  while (log_->segments() > 1) {
    {
      MutexLock lock(mutex_);
      if (index_.memory_bytes() <= max_memory) return;
    }
    if (!DropOldestSegment()) return;  // the next insert tries again
  }
}

RateLimiter::Hold ReplayTable::MaySample(const TrajectoryShape& shape) {
  MutexLock lock(mutex_);
  last_count_ = static_cast<size_t>(shape.count);
  return limiter_.MaySample(Samples(shape), Sampleable(last_count_));
}

int64_t ReplayTable::Sampleable(size_t count) const {
  return index_.CanSample(count) ? static_cast<int64_t>(index_.items()) : 0;
}

Status ReplayTable::CheckShape(const TrajectoryShape& shape) const {
  if (shape.count < 1 || shape.count > kMaxBatch) {
    return Fail(ErrorCode::kInvalidArgument, "a batch of {} is not between 1 and {}", shape.count, kMaxBatch);
  }
  const int most = shape.all_observations ? options_.replay.sequence_length : options_.n_step;
  if (shape.steps < 1 || shape.steps > most) {
    return Fail(ErrorCode::kInvalidArgument,
                "trajectories of {} steps{}; this replay was started with {} {}; start both with the "
                "configuration of the run",
                shape.steps, shape.all_observations ? " with all observations" : "",
                shape.all_observations ? "replay.sequence_length" : "algorithm.n_step", most);
  }
  if (Samples(shape) > kMaxBatchSteps) {
    return Fail(ErrorCode::kInvalidArgument,
                "a batch of {} trajectories of {} steps; at most {} steps fit into one", shape.count,
                shape.steps, kMaxBatchSteps);
  }
  return {};
}

Result<SampledItems> ReplayTable::SampleItems(const TrajectoryShape& shape, uint32_t policy_version) {
  DADRL_RETURN_IF_ERROR(CheckShape(shape));
  const int64_t samples = Samples(shape);
  const auto count = static_cast<size_t>(shape.count);
  MutexLock lock(mutex_);
  index_.SetNewestVersion(policy_version);
  if (limiter_.MaySample(samples, Sampleable(count)) != RateLimiter::Hold::kNone) {
    return Fail(ErrorCode::kUnavailable, "{} samples of {} items have to wait for inserts", samples,
                index_.items());
  }
  SampledItems sampled = index_.SampleItems(count, shape.steps, random_);
  limiter_.OnSample(samples);
  return sampled;
}

Result<SampledBatch> ReplayTable::Sample(const TrajectoryShape& shape, uint32_t policy_version) {
  DADRL_ASSIGN_OR_RETURN(SampledItems sampled, SampleItems(shape, policy_version));
  return ReadTrajectories(std::move(sampled), shape);
}

void ReplayTable::UpdatePriorities(std::span<const uint64_t> keys, std::span<const float> priorities) {
  MutexLock lock(mutex_);
  for (size_t i = 0; i < std::min(keys.size(), priorities.size()); ++i) {
    if (options_.bounds.AllowsPriority(priorities[i])) {
      index_.UpdatePriority(keys[i], priorities[i]);
    } else if (counters_.refused_priorities++ == 0) {
      spdlog::warn("refused the priority {:g} of item {:#x} (more are counted): they are from 0 to {:.4g}",
                   priorities[i], keys[i], options_.bounds.priority);
    }
  }
}

bool ReplayTable::MayInsert() const {
  MutexLock lock(mutex_);
  // A batch that cannot be sampled pays no debt.
  return limiter_.MayInsert(Sampleable(last_count_));
}

void ReplayTable::Reconfigure(const RateLimiter::Options& options) {
  MutexLock lock(mutex_);
  limiter_.Reconfigure(options);
}

RateLimiter::Options ReplayTable::limiter_options() const {
  MutexLock lock(mutex_);
  return limiter_.options();
}

std::vector<SequenceTable::Stream> ReplayTable::Streams() const {
  MutexLock lock(insert_mutex_);
  return sequences_.Newest();
}

std::optional<SequenceTable::Stream> ReplayTable::StreamOf(uint32_t actor) const {
  MutexLock lock(insert_mutex_);
  return sequences_.Newest(actor);
}

std::optional<uint64_t> ReplayTable::Stored(uint32_t actor, uint64_t incarnation) const {
  MutexLock lock(insert_mutex_);
  return sequences_.Stored(actor, incarnation);
}

void ReplayTable::TrimMemory() const {
  const auto max_memory = static_cast<uint64_t>(options_.replay.max_memory_bytes);
  uint64_t index_bytes = 0;
  {
    MutexLock lock(mutex_);
    index_bytes = index_.memory_bytes();
  }
  log_->DropPagesBeyond(max_memory - std::min(max_memory, index_bytes));
}

ReplayTable::Stats ReplayTable::stats() const {
  MutexLock lock(mutex_);
  Stats stats = counters_;
  stats.inserted_frames = static_cast<uint64_t>(limiter_.state().inserted);
  stats.sampled = static_cast<uint64_t>(limiter_.state().sampled);
  stats.frames_held = index_.frames();
  stats.items = index_.items();
  stats.chunks_held = index_.chunks();
  stats.index_bytes = index_.memory_bytes();
  stats.disk_bytes = log_->bytes();
  return stats;
}

}  // namespace dadrl
