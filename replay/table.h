// The replay itself, without a network: durable experience in, sampled batches out.
//
//   Insert ──► SequenceTable (exactly once) ──► SegmentLog (on disk) ──► ChunkIndex (what can be sampled)
//   Sample ◄── ReadTrajectories (straight from the mapped files) ◄── ChunkIndex
//
// What is stored survives the death of the process as soon as Insert returns, and that of the machine after
// the next Sync. Both bounds drop the oldest segment first: replay.max_disk_bytes those of the files,
// replay.max_memory_bytes the index; what remains of the latter is how much of the files TrimMemory leaves
// resident.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/config/config.h"
#include "common/util/clock.h"
#include "common/util/enum_array.h"
#include "common/util/mutex.h"
#include "common/util/random.h"
#include "common/util/result.h"
#include "common/util/time_ledger.h"
#include "proto/experience.h"
#include "proto/experience_bounds.h"
#include "replay/chunk_index.h"
#include "replay/rate_limiter.h"
#include "replay/sequence_table.h"
#include "replay/storage/segment_log.h"
#include "replay/storage/snapshot.h"
#include "replay/storage/state_file.h"
#include "replay/trajectory_reader.h"

namespace dadrl {

struct TableOptions {
  std::filesystem::path directory;  // of this shard; empty: in memory only
  StepSpec spec;                    // of the steps: chunks of another schema are refused
  ReplayConfig replay;
  int n_step = 1;     // steps of the longest trajectories without all observations that will be asked for
  uint64_t seed = 1;  // of the sampling
  // Of rewards and priorities: what is beyond them is refused, and dropped when it is found on disk.
  ExperienceBounds bounds = ExperienceBounds::From(Config{});
  // Looks at each new chunk's payloads before it is stored; null: they are trusted. A chunk that fails is
  // dropped, and its actor need not keep it: the episode breaks off there.
  std::function<Status(const ChunkView&)> verify = nullptr;
  Segment::Force force = SyncFile;
};

// Why a chunk is not taken, and never will be.
struct ChunkRefusal {
  ChunkFault fault{};
  std::string reason;
};

// RateLimiter::Options of one shard of a configuration: the band in frames.
RateLimiter::Options LimiterOptions(const ReplayConfig& replay);

// Of one segment file: replay.segment_bytes, but so that dropping the oldest never drops most of what is
// there, and that there are never more segments than a process may map.
uint64_t SegmentBytes(const ReplayConfig& replay);

// Any thread may call anything. Inserts exclude each other, and saving for the moment in which it looks.
class ReplayTable {
 public:
  // Full segments that may wait to be forced to the device, unless replay.sync is none.
  static constexpr size_t kMaxUnforced = 4;
  // Of a batch: trajectories, and steps of all that have all their observations.
  static constexpr int kMaxBatch = 65536;
  static constexpr int64_t kMaxBatchSteps = int64_t{1} << 21;

  struct Stats {
    uint64_t inserted_frames = 0;  // with a decision, since the run began
    uint64_t inserted_bytes = 0;   // since this process started, as are the following
    uint64_t duplicate_chunks = 0;
    EnumArray<ChunkFault, uint64_t> rejected_chunks{};
    uint64_t damaged_frames = 0;  // stored once, and unreadable since
    uint64_t lost_chunks = 0;     // skipped: their actors no longer have them
    uint64_t refused_priorities = 0;
    uint64_t sampled = 0;      // as MaySample counts them, since the run began
    uint64_t frames_held = 0;  // with a decision
    uint64_t items = 0;        // of them, those that can be sampled
    uint64_t chunks_held = 0;
    uint64_t index_bytes = 0;
    uint64_t disk_bytes = 0;
    TimeSpent for_disk;  // inserts that had to begin a segment
  };
  enum class Insertion {
    kStored,
    kDuplicate,
    kEarly,     // not stored: one before it is still to come
    kRejected,  // not stored, and never will be; where its identity can be read, its sequence counts as done
  };

  // Recovers what is in the directory, logs what it found. Borrows `clock`. kCorrupt: other schema;
  // kUnavailable: another process has it; others: the folder cannot be used.
  static Result<std::unique_ptr<ReplayTable>> Open(TableOptions options, const Clock& clock);

  // `oldest_kept` as in dadrl_idl.ChunkMessage. kExhausted: the disk is full (or the chunk larger than it may
  // get); nothing was stored, the same chunk may be offered again. Begins a new segment when one is full, and
  // leaves the full one to Sync; blocks on the disk only when kMaxUnforced of them wait for that, or when the
  // oldest has to leave and no state was saved since it was full. `refusal` is set when it was kRejected.
  Result<Insertion> Insert(std::span<const std::byte> chunk, uint64_t oldest_kept = 0,
                           ChunkRefusal* refusal = nullptr);
  // A rejected chunk whose bytes do not say whose it was: its sequence counts as done, if it is the next.
  void Settle(const ChunkIdentity& identity, uint64_t oldest_kept) DADRL_EXCLUDES(insert_mutex_);
  // The newest incarnation of each actor, with its highest stored sequence.
  std::vector<SequenceTable::Stream> Streams() const;
  std::optional<SequenceTable::Stream> StreamOf(uint32_t actor) const;
  std::optional<uint64_t> Stored(uint32_t actor, uint64_t incarnation) const;

  // Writes the state file: what a restart finds of counters, limiter and priorities. Blocks on the disk,
  // inserts and samples only for a copy in memory.
  Status SaveState();
  // The same if a segment was begun since: then the oldest can leave without Insert's waiting for it.
  Status SaveStateOfNewSegment();
  // The table as it is at one moment, complete in `directory` (storage/snapshot.h). Blocks as SaveState does.
  // kInvalidArgument: the folder exists, or the table is in memory only.
  Result<SnapshotReport> Snapshot(const std::filesystem::path& directory);

  // Whether a batch may be sampled now, and if not, why: ask again after inserts. A trajectory with all its
  // observations counts as so many samples as it has steps, else as one.
  RateLimiter::Hold MaySample(const TrajectoryShape& shape);
  // Samples a batch, to be read by ReadTrajectories without a lock, so that inserts and other samplings go on
  // meanwhile. `policy_version`: the newest, for the staleness limit; 0 when unknown. kUnavailable: MaySample
  // would not allow it, or what was there went stale; kInvalidArgument: CheckShape.
  Result<SampledItems> SampleItems(const TrajectoryShape& shape, uint32_t policy_version);
  // Samples and reads.
  Result<SampledBatch> Sample(const TrajectoryShape& shape, uint32_t policy_version);
  // kInvalidArgument: such batches can never be sampled; names the limit.
  Status CheckShape(const TrajectoryShape& shape) const;
  // Priorities that are no numbers, negative or beyond the bound are refused: counted, the first is logged.
  void UpdatePriorities(std::span<const uint64_t> keys, std::span<const float> priorities);

  // Whether actors may send more.
  bool MayInsert() const;
  // Other bounds for the limiter, from now on; over restarts too, until the configuration changes.
  void Reconfigure(const RateLimiter::Options& options);
  RateLimiter::Options limiter_options() const;

  // Forces what is stored to the device. Blocks on the disk.
  Status Sync() { return log_->Sync(); }
  // Lets what cannot be read any more go (a failing disk, a file cut short): it is not sampled, nothing is
  // added to its segment. kCorrupt, with the file, while a damaged segment is there. Cheap when there is
  // none.
  Status DropDamaged();
  // Keeps this process's resident pages of old segments under what replay.max_memory_bytes leaves for them.
  void TrimMemory() const;

  Stats stats() const;
  uint64_t schema() const { return schema_; }
  const std::filesystem::path& directory() const { return options_.directory; }

 private:
  // Everything that is not in the segments, at one moment, and what segments there are.
  struct Capture {
    uint64_t number = 0;
    ReplayState state;
    std::vector<SegmentLog::Extent> extents;
  };

  ReplayTable(TableOptions options, const Clock& clock);
  Status Recover();
  // True when the record is a chunk of ours, and now in the index.
  bool RecoverRecord(const std::shared_ptr<const Segment>& segment, std::span<const std::byte> record);
  void RestoreState();
  void RestoreLimiter(const ReplayState& state) DADRL_REQUIRES(mutex_);
  Capture TakeCapture() DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  Status ForceAndWriteState(const Capture& capture) DADRL_EXCLUDES(state_mutex_);

  // The items, or 0 while they do not suffice for a batch of `count`: each serves max_times_sampled times.
  int64_t Sampleable(size_t count) const DADRL_REQUIRES(mutex_);
  Insertion Refuse(ChunkFault fault, const Error& reason, ChunkRefusal* refusal) DADRL_EXCLUDES(mutex_);
  Result<Insertion> InsertParsed(const ChunkView& chunk, uint64_t oldest_kept, ChunkRefusal* refusal)
      DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  Insertion Decline(SequenceTable::Verdict verdict, const ChunkIdentity& identity, ChunkRefusal* refusal)
      DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  Error StaleError(const ChunkIdentity& identity) const DADRL_REQUIRES(insert_mutex_);
  void SettleNext(const ChunkIdentity& identity, uint64_t oldest_kept) DADRL_REQUIRES(insert_mutex_)
      DADRL_EXCLUDES(mutex_);
  Status CheckContents(const ChunkView& chunk) const;
  Status Store(ChunkView chunk) DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  Status EnsureSegment(size_t length) DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  Status RollSegment(size_t length) DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  Status DropOldestSegment() DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  void BoundIndex() DADRL_REQUIRES(insert_mutex_) DADRL_EXCLUDES(mutex_);
  std::filesystem::path StatePath() const { return options_.directory / "state"; }

  const TableOptions options_;
  const uint64_t schema_;
  const Clock& clock_;
  std::unique_ptr<SegmentLog> log_;

  // Taken in this order.
  mutable Mutex insert_mutex_;
  SequenceTable sequences_ DADRL_GUARDED_BY(insert_mutex_);
  LogPosition end_ DADRL_GUARDED_BY(insert_mutex_);  // behind the last chunk stored
  uint64_t captures_ DADRL_GUARDED_BY(insert_mutex_) = 0;

  mutable Mutex mutex_;
  ChunkIndex index_ DADRL_GUARDED_BY(mutex_);
  RateLimiter limiter_ DADRL_GUARDED_BY(mutex_);
  Random random_ DADRL_GUARDED_BY(mutex_);
  size_t last_count_ DADRL_GUARDED_BY(mutex_) = 1;  // that MaySample was asked for
  bool too_small_reported_ DADRL_GUARDED_BY(mutex_) = false;
  Stats counters_ DADRL_GUARDED_BY(mutex_);  // only what the parts do not know themselves

  // Before this one every segment is in the state on disk.
  std::atomic<uint64_t> saved_segment_{0};
  std::atomic<bool> new_segment_{false};  // since the last capture for the state file

  // Of the writes to the state file: an older capture never replaces a newer one.
  Mutex state_mutex_;
  uint64_t written_ DADRL_GUARDED_BY(state_mutex_) = 0;
};

}  // namespace dadrl
