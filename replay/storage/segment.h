// One append-only file of checksummed records, read through a memory mapping.
//
// File, little endian: magic u64, version u32, 0 u32, segment id u64, schema u64, xxh3-64 of these | records.
// Record: magic u32, length u32, xxh3-64 of the content u64, xxh3-64 of (segment id, offset, the three
// before) u64 | content | zeros up to a multiple of 8. The record's own place is in its checksum, so that
// neither stale blocks nor content that looks like a record is taken for one.
#pragma once

#include <atomic>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>

#include "common/io/file_descriptor.h"
#include "common/io/guarded_mapping.h"
#include "common/util/mutex.h"
#include "common/util/result.h"

namespace dadrl {

// A place in a log of segments.
struct LogPosition {
  uint64_t segment = 0;
  uint64_t offset = 0;  // within its file
  auto operator<=>(const LogPosition&) const = default;
};

// One thread appends; any thread may read records it was handed, sync, or drop pages. Shared ownership: a
// sampled batch keeps the mapping alive after the log has dropped the segment. Holds a descriptor only while
// it may be appended to: there can be thousands of segments.
class Segment {
 public:
  // What a scan found.
  struct Scan {
    uint64_t records = 0;
    uint64_t dropped_bytes = 0;     // belonged to no whole record, in the middle or at the end
    uint64_t rejected_records = 0;  // whole, but refused by the visitor
    bool unreadable = false;        // in part: the device does not deliver it
  };
  using Visitor = std::function<bool(std::span<const std::byte> record)>;
  // Forces a file to the device; SyncFile, but for tests of disks that fail.
  using Force = std::function<Status(const FileDescriptor&, const std::filesystem::path&)>;

  // A new, empty one of at most `capacity` bytes; `path` empty: in memory only. kExhausted: disk full.
  static Result<std::shared_ptr<Segment>> Create(const std::filesystem::path& path, uint64_t id,
                                                 uint64_t schema, uint64_t capacity, Force force = SyncFile);
  // An existing one, closed for appending; also where it can only be read. kCorrupt when it is of another
  // schema or version, with the remedy; kInvalidArgument when it is no file of ours: a link, a FIFO, longer
  // than any segment. A damaged header alone loses nothing: the records prove themselves.
  static Result<std::shared_ptr<Segment>> Open(const std::filesystem::path& path, uint64_t id,
                                               uint64_t schema, Force force = SyncFile);
  Segment(const Segment&) = delete;
  Segment& operator=(const Segment&) = delete;

  // Bytes that a record of `length` takes.
  static uint64_t RecordBytes(size_t length);
  static uint64_t HeaderBytes();
  bool Fits(size_t length) const { return used_ + RecordBytes(length) <= capacity_; }

  // Writes one record and returns it as mapped. Survives the death of this process when it returns; survives
  // that of the machine after the next Sync. kExhausted: the disk is full, nothing was appended.
  Result<std::span<const std::byte>> Append(std::span<const std::byte> content);

  // Visits each whole record, oldest first. What is torn, damaged or cannot be read is stepped over; a torn
  // end is cut off, where that is possible.
  Scan Recover(const Visitor& visit);
  // Nothing is appended any more.
  void Seal() DADRL_EXCLUDES(file_mutex_);

  // Forces what was appended to the device. Blocks on the disk. After a failure the system takes what it
  // could not write for written: the next call writes all of it once more. Of a segment that was removed, or
  // is damaged, there is nothing to force.
  Status Sync() const DADRL_EXCLUDES(sync_mutex_);
  // Takes the mapping's pages out of this process's resident memory; they are read again when needed.
  void DropPages() const;
  // Removes the file's name; the mapping stays for those who hold it.
  void Unlink();
  // Whether, after Recover, a reader met a page that the device does not deliver or that was cut off: its
  // bytes read as zeros.
  bool damaged() const { return mapping_.damaged(); }

  uint64_t id() const { return id_; }
  // Where a record that was handed out begins within the file.
  uint64_t OffsetOf(std::span<const std::byte> record) const {
    return static_cast<uint64_t>(record.data() - mapping_.bytes().data());
  }
  uint64_t bytes() const { return used_; }
  // The file's first `bytes`, as mapped; no more than bytes().
  std::span<const std::byte> Prefix(uint64_t bytes) const { return mapping_.bytes().first(bytes); }
  const std::filesystem::path& path() const { return path_; }

 private:
  using SharedFile = std::shared_ptr<const FileDescriptor>;  // closed once nobody appends or forces

  Segment(std::filesystem::path path, uint64_t id, FileDescriptor file, Force force);
  Status Map(uint64_t length);
  Status WriteHeader(uint64_t schema);
  Status WriteAgain(const FileDescriptor& file) const;
  // The open file, or the sealed one opened again. That loses no word of a failed write: Linux keeps it for
  // the next descriptor that asks, as long as somebody holds the file, and the mapping does.
  Result<SharedFile> File() const DADRL_EXCLUDES(file_mutex_);
  const FileDescriptor& AppendedFile() const DADRL_NO_THREAD_SAFETY_ANALYSIS { return *file_; }

  std::filesystem::path path_;
  uint64_t id_;
  mutable Mutex file_mutex_;
  SharedFile file_ DADRL_GUARDED_BY(file_mutex_);  // null once sealed; the appending thread may read it
  std::atomic<bool> unlinked_{false};
  const Force force_;
  // One at a time: the system tells of a failure once.
  mutable Mutex sync_mutex_;
  mutable bool failed_ DADRL_GUARDED_BY(sync_mutex_) = false;
  uint64_t capacity_ = 0;          // of the mapping
  std::atomic<uint64_t> used_{0};  // written by the appending thread, read by all
  GuardedMapping mapping_;
};

}  // namespace dadrl
