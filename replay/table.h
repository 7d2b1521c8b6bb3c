// The replay itself, without a network: durable experience in, sampled batches out.
//
//   Insert ──► SequenceTable (exactly once) ──► SegmentLog (on disk) ──► ChunkIndex (what can be drawn)
//   Sample ◄── AssembleBatch (n-step slices, straight from the mapped files) ◄── ChunkIndex
//
// What is stored survives the death of the process as soon as Insert returns, and that of the machine after
// the next Sync. Both bounds drop the oldest segment first: replay.max_disk_bytes those of the files,
// replay.max_memory_bytes the index; what remains of the latter is how much of the files TrimMemory leaves
// resident.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "common/config/config.h"
#include "common/util/clock.h"
#include "common/util/mutex.h"
#include "common/util/random.h"
#include "common/util/result.h"
#include "proto/experience.h"
#include "replay/chunk_index.h"
#include "replay/rate_limiter.h"
#include "replay/sequence_table.h"
#include "replay/slice.h"
#include "replay/storage/segment_log.h"

namespace dadrl {

struct TableOptions {
  std::filesystem::path directory;  // of this shard; empty: in memory only
  uint64_t schema = 0;              // chunks of another are refused
  ReplayConfig replay;
  int n_step = 1;     // of the longest slices that will be asked for
  uint64_t seed = 1;  // of the draws
  // Looks at each new chunk's payloads before it is stored; null: they are trusted. A chunk that fails is
  // dropped, and its actor need not keep it: the episode breaks off there.
  std::function<Status(const ChunkView&)> verify = nullptr;
};

// RateLimiter::Options of a configuration: the band in frames.
RateLimiter::Options LimiterOptions(const ReplayConfig& replay);

// Insert, Streams, SaveState: one thread. Everything else: any thread.
class ReplayTable {
 public:
  struct Stats {
    uint64_t inserted_frames = 0;  // with an action, since the run began
    uint64_t inserted_bytes = 0;   // since this process started, as are the following
    uint64_t duplicate_chunks = 0;
    uint64_t rejected_chunks = 0;  // malformed, alien schema, stale incarnation
    uint64_t early_chunks = 0;     // dropped because one before them is still to come
    uint64_t lost_chunks = 0;      // skipped: their actors no longer have them
    uint64_t sampled = 0;          // transitions, since the run began
    uint64_t frames_held = 0;      // with an action
    uint64_t items = 0;            // of them, those that can be sampled
    uint64_t chunks_held = 0;
    uint64_t index_bytes = 0;
    uint64_t disk_bytes = 0;
    RateLimiter::Waits waits;
  };
  enum class Insertion {
    kStored,
    kDuplicate,
    kEarly,     // not stored: one before it is still to come
    kRejected,  // not stored, and never will be; if only its frames are bad, its sequence counts as done
  };

  // Recovers what is in the directory, logs what it found. Borrows `clock`. kCorrupt: other schema;
  // kUnavailable: another process has it; others: the folder cannot be used.
  static Result<std::unique_ptr<ReplayTable>> Open(TableOptions options, const Clock& clock);

  // `oldest_kept` as in dadrl_idl.ChunkMessage. kExhausted: the disk is full (or the chunk larger than it may
  // get); nothing was stored, the same chunk may be offered again. Blocks on the disk when a segment is full.
  Result<Insertion> Insert(std::span<const std::byte> chunk, uint64_t oldest_kept = 0);
  // The newest incarnation of each actor, with its highest stored sequence.
  std::vector<SequenceTable::Stream> Streams() const { return sequences_.Newest(); }
  std::optional<SequenceTable::Stream> StreamOf(uint32_t actor) const { return sequences_.Newest(actor); }
  std::optional<uint64_t> Stored(uint32_t actor, uint64_t incarnation) const {
    return sequences_.Stored(actor, incarnation);
  }
  // Writes the state file, so that a clean restart restores all counters. Blocks on the disk.
  Status SaveState();

  // Whether a batch may be sampled now, and if not, why: ask again after inserts. Counts the wait.
  RateLimiter::Hold MaySample(size_t count);
  // Draws `count` slices of `n_step` (at most TableOptions::n_step). `policy_version` is the newest, for the
  // staleness limit; 0 when unknown. kUnavailable: MaySample would not allow it, or what was there went
  // stale. The lock is held only for the draw, so that inserts go on while a batch is read.
  Result<SampledBatch> Sample(size_t count, int n_step, uint32_t policy_version);
  void UpdatePriorities(std::span<const uint64_t> keys, std::span<const float> priorities);

  // Whether actors may send more. Counts the wait.
  bool MayInsert();
  // Other bounds for the limiter, from now on.
  void Reconfigure(const RateLimiter::Options& options);

  // Forces what is stored to the device. Blocks on the disk.
  Status Sync() const { return log_->Sync(); }
  // Keeps this process's resident pages of old segments under what replay.max_memory_bytes leaves for them.
  void TrimMemory() const;

  Stats stats() const;
  uint64_t schema() const { return options_.schema; }
  int n_step() const { return options_.n_step; }

 private:
  ReplayTable(TableOptions options, const Clock& clock);
  Status Recover();
  // True when the record is a chunk of ours, and now in the index.
  bool RecoverRecord(const std::shared_ptr<const Segment>& segment, std::span<const std::byte> record);
  Status RestoreState();
  Result<ChunkView> Parse(std::span<const std::byte> bytes) const;
  Insertion Refuse(const Error& reason) DADRL_EXCLUDES(mutex_);
  Status Store(ChunkView chunk) DADRL_EXCLUDES(mutex_);
  Status EnsureSegment(size_t length);
  void DropOldestSegment() DADRL_EXCLUDES(mutex_);
  void BoundIndex() DADRL_EXCLUDES(mutex_);
  std::filesystem::path StatePath() const;

  const TableOptions options_;
  std::unique_ptr<SegmentLog> log_;

  // The inserting thread's.
  SequenceTable sequences_;
  uint64_t last_segment_ = 0;  // of the last chunk stored

  mutable Mutex mutex_;
  ChunkIndex index_ DADRL_GUARDED_BY(mutex_);
  RateLimiter limiter_ DADRL_GUARDED_BY(mutex_);
  Random random_ DADRL_GUARDED_BY(mutex_);
  Stats counters_ DADRL_GUARDED_BY(mutex_);  // only what the parts do not know themselves
};

}  // namespace dadrl
