// What the table does for the restart: finds what is there, saves what the segments do not hold.
#include <algorithm>
#include <utility>

#include "common/util/log.h"
#include "replay/storage/columns_file.h"
#include "replay/table.h"

namespace dadrl {
namespace {

// One that is beyond the bound is as important as an item can be.
void LimitPriorities(double most, ItemStates& items) {
  items.max_priority = std::min(items.max_priority, most);
  for (float& priority : items.priorities) priority = std::min(priority, static_cast<float>(most));
}

}  // namespace

Status ReplayTable::Recover() {
  const SegmentLog::Options log_options{options_.directory, schema_, SegmentBytes(options_.replay),
                                        options_.force};
  SegmentLog::Recovery recovery;
  DADRL_ASSIGN_OR_RETURN(log_, SegmentLog::Open(
                                   log_options,
                                   [this](const auto& segment, std::span<const std::byte> record) {
                                     return RecoverRecord(segment, record);
                                   },
                                   recovery));
  if (options_.directory.empty()) return {};
  if (const Status written = WriteColumns(options_.directory, options_.spec); !written) {
    spdlog::warn("{}: readers of this folder alone may not know its columns", written.error().message);
  }
  RestoreState();
  MutexLock inserting(insert_mutex_);
  while (log_->segments() > 1 && log_->bytes() > static_cast<uint64_t>(options_.replay.max_disk_bytes)) {
    // Where the state cannot be saved, none may leave: the next insert that begins a segment tries again.
    if (!DropOldestSegment()) break;
  }
  BoundIndex();
  const Stats now = stats();
  if (recovery.records > 0 || recovery.dropped_bytes > 0 || recovery.rejected_records > 0) {
    spdlog::info(
        "recovered {} frames in {} chunks and {} segments; dropped {} damaged or torn bytes and {} unusable "
        "chunks",
        now.frames_held, now.chunks_held, recovery.segments, recovery.dropped_bytes,
        recovery.rejected_records);
  }
  return {};
}

// True when the record is a chunk of ours, and now in the index.
bool ReplayTable::RecoverRecord(const std::shared_ptr<const Segment>& segment,
                                std::span<const std::byte> record) {
  const Result<ChunkView> chunk = ChunkView::Parse(record);
  if (!chunk || chunk->header().schema != schema_) return false;
  if (!CheckRewards(*chunk, options_.bounds) || !CheckDecisions(*chunk, options_.spec)) return false;
  MutexLock inserting(insert_mutex_);
  // A gap is a record that was damaged; what follows it is as good as ever.
  const ChunkIdentity& identity = chunk->header().identity;
  if (sequences_.Check(identity, identity.sequence) != SequenceTable::Verdict::kNext) return false;
  sequences_.Accept(identity);
  end_ = {segment->id(), segment->OffsetOf(record) + record.size()};
  MutexLock lock(mutex_);
  index_.Add(segment, *chunk);
  return true;
}

// The state file knows what dropped segments held, up to the place it names; the records know the rest.
void ReplayTable::RestoreState() {
  Result<ReplayState> found = ReadReplayState(StatePath(), MaxStateBytes(log_->bytes()));
  if (!found && found.error().code != ErrorCode::kNotFound) {
    spdlog::warn("{}: counters and priorities start anew; stored experience is not affected",
                 found.error().message);
  }
  ReplayState state;
  if (found && found->schema == schema_) state = std::move(*found);
  LimitPriorities(options_.bounds.priority, state.items);
  MutexLock inserting(insert_mutex_);
  MutexLock lock(mutex_);
  sequences_.Merge(state.sequences);
  RestoreLimiter(state);
  index_.Restore(state.items);
  index_.RemoveSurplus(random_);
  end_ = std::max(end_, state.up_to);
  log_->ReserveIds(state.up_to.segment);
  saved_segment_.store(state.up_to.segment);
}

void ReplayTable::RestoreLimiter(const ReplayState& state) {
  const RateLimiter::Options configured = LimiterOptions(options_.replay);
  if (state.limiter_change && state.limiter_change->configured == configured) {
    limiter_.Reconfigure(state.limiter_change->current);
    spdlog::info("the rate limiter keeps the bounds that were set while running");
  }
  limiter_.Restore(state.limiter);
  limiter_.OnInsert(static_cast<int64_t>(index_.FramesBehind(state.up_to)));
}

ReplayTable::Capture ReplayTable::TakeCapture() {
  Capture capture{.number = ++captures_, .state = {}, .extents = log_->Extents()};
  ReplayState& state = capture.state;
  state.schema = schema_;
  state.up_to = end_;
  state.sequences = sequences_;
  MutexLock lock(mutex_);
  state.limiter = limiter_.state();
  const RateLimiter::Options configured = LimiterOptions(options_.replay);
  if (limiter_.options() != configured) state.limiter_change = {configured, limiter_.options()};
  state.items = index_.States();
  return capture;
}

Status ReplayTable::SaveState() {
  new_segment_.store(false);
  Capture capture;
  {
    MutexLock inserting(insert_mutex_);
    capture = TakeCapture();
  }
  Status saved = ForceAndWriteState(capture);
  if (!saved) new_segment_.store(true);
  return saved;
}

Status ReplayTable::DropDamaged() {
  const std::shared_ptr<const Segment> damaged = log_->FirstDamaged();
  if (!damaged) return {};
  MutexLock inserting(insert_mutex_);
  MutexLock lock(mutex_);
  counters_.damaged_frames += index_.DropDamaged();
  return Fail(ErrorCode::kCorrupt,
              "cannot read {}: the device reports an error, or the file was cut short; {} frames are lost",
              damaged->path().string(), counters_.damaged_frames);
}

Status ReplayTable::SaveStateOfNewSegment() { return new_segment_.load() ? SaveState() : Status(); }

Status ReplayTable::ForceAndWriteState(const Capture& capture) {
  if (options_.directory.empty()) return {};
  // What the state calls stored must not be lost behind it: its chunks would be taken for duplicates.
  if (options_.replay.sync != SyncMode::kNone) DADRL_RETURN_IF_ERROR(log_->Sync());
  MutexLock lock(state_mutex_);
  if (capture.number < written_) return {};
  DADRL_RETURN_IF_ERROR(WriteReplayState(StatePath(), capture.state));
  written_ = capture.number;
  saved_segment_.store(capture.state.up_to.segment);
  return {};
}

Result<SnapshotReport> ReplayTable::Snapshot(const std::filesystem::path& directory) {
  if (options_.directory.empty()) {
    return Fail(ErrorCode::kInvalidArgument, "a replay in memory has no files to make a snapshot of");
  }
  Capture capture;
  {
    MutexLock inserting(insert_mutex_);
    capture = TakeCapture();
  }
  return WriteSnapshot(capture.state, options_.spec, capture.extents, directory);
}

}  // namespace dadrl
