// The replay's experience on disk: segments in a folder, the newest one open for appending.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/util/mutex.h"
#include "common/util/result.h"
#include "replay/storage/segment.h"

namespace dadrl {

// One thread appends, rolls and removes; Sync, unforced, FirstDamaged, DropPagesBeyond and the byte counts
// are for any thread.
class SegmentLog {
 public:
  struct Options {
    std::filesystem::path directory;  // created when missing; empty: segments live in memory only
    uint64_t schema = 0;
    uint64_t segment_bytes = uint64_t{64} << 20;
    Segment::Force force = SyncFile;
  };
  // What recovery found.
  struct Recovery {
    uint64_t segments = 0;
    uint64_t records = 0;
    uint64_t bytes = 0;
    uint64_t dropped_bytes = 0;     // damaged or torn
    uint64_t rejected_records = 0;  // whole, but the visitor refused them
    uint64_t refused_files = 0;     // named like a segment, and none of ours: a link, a FIFO, far too long
    uint64_t unreadable = 0;  // segments that the device delivers in part or not at all; they stay there
  };
  using Visitor = std::function<bool(const std::shared_ptr<const Segment>&, std::span<const std::byte>)>;

  // Takes the folder for this process (kUnavailable when another one has it) and visits every whole record,
  // oldest first. kCorrupt: a segment is of another schema. Logs what was dropped.
  static Result<std::unique_ptr<SegmentLog>> Open(const Options& options, const Visitor& visit,
                                                  Recovery& recovery);

  static std::string NameOf(uint64_t id);
  // Of a segment's file name; nothing when it is none.
  static std::optional<uint64_t> IdOf(const std::filesystem::path& path);

  struct Stored {
    std::shared_ptr<const Segment> segment;
    std::span<const std::byte> bytes;
  };

  // True when a record of `length` needs a new segment: call StartSegment before Append.
  bool NeedsSegment(size_t length) const;
  // The bytes a segment started for a record of `length` may grow to.
  uint64_t NextSegmentBytes(size_t length) const;
  // Ends the open segment; the next Sync forces it. Without one: nothing.
  void CloseSegment();
  // Opens the next one; none is open. kExhausted: disk full, try again later.
  Status StartSegment(size_t length);
  // Needs a segment that fits. kExhausted: disk full, nothing was appended.
  Result<Stored> Append(std::span<const std::byte> record);

  // No new segment takes an id up to this one: ids are never reused, even when all segments are gone.
  void ReserveIds(uint64_t up_to) { next_id_ = std::max(next_id_, up_to + 1); }

  // A segment as it is now: sealed ones never change again, the open one only grows.
  struct Extent {
    std::shared_ptr<const Segment> segment;
    uint64_t bytes = 0;
    bool sealed = true;
  };
  // All segments, oldest first. Not while another thread appends.
  std::vector<Extent> Extents() const;

  // Removes the oldest segment's file.
  void RemoveOldest();
  size_t segments() const;
  uint64_t oldest_id() const;

  // The oldest segment that cannot be read any more; null when there is none.
  std::shared_ptr<const Segment> FirstDamaged() const;

  // Bytes of all segments.
  uint64_t bytes() const;
  // Forces everything appended before the call to the device, what recovery found included; blocks on the
  // disk. What could not be forced is tried again by the next call.
  Status Sync();
  // Closed segments that Sync has still to force.
  size_t unforced() const;
  // Keeps at most `bytes` of the newest segments in this process's resident memory.
  void DropPagesBeyond(uint64_t bytes) const;

  const std::filesystem::path& directory() const { return options_.directory; }

 private:
  explicit SegmentLog(Options options) : options_(std::move(options)) {}
  Status Lock();
  Status Recover(const Visitor& visit, Recovery& recovery);
  std::filesystem::path PathOf(uint64_t id) const;

  Options options_;
  FileDescriptor lock_;
  mutable Mutex mutex_;
  std::deque<std::shared_ptr<Segment>> segments_ DADRL_GUARDED_BY(mutex_);
  uint64_t bytes_ DADRL_GUARDED_BY(mutex_) = 0;
  std::deque<std::shared_ptr<const Segment>> unforced_ DADRL_GUARDED_BY(mutex_);  // closed, oldest first
  // Of the folder: names that were added to it, and those of them that are on the device.
  uint64_t names_ DADRL_GUARDED_BY(mutex_) = 0;
  uint64_t forced_names_ DADRL_GUARDED_BY(mutex_) = 0;
  // Appended to by the one appending thread; null after recovery and after a failed start.
  std::shared_ptr<Segment> open_;
  uint64_t next_id_ = 1;
};

}  // namespace dadrl
