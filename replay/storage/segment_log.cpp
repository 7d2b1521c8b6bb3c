#include "replay/storage/segment_log.h"

#include <fcntl.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "common/io/atomic_file.h"
#include "common/io/io_error.h"
#include "common/util/log.h"
#include "replay/storage/segment_format.h"

namespace dadrl {
namespace {

constexpr std::string_view kPrefix = "segment-";
constexpr std::string_view kSuffix = ".log";

}  // namespace

std::string SegmentLog::NameOf(uint64_t id) { return fmt::format("{}{:012}{}", kPrefix, id, kSuffix); }

std::optional<uint64_t> SegmentLog::IdOf(const std::filesystem::path& path) {
  const std::string name = path.filename().string();
  if (!name.starts_with(kPrefix) || !name.ends_with(kSuffix)) return std::nullopt;
  uint64_t id = 0;
  std::from_chars(name.data() + kPrefix.size(), name.data() + name.size(), id);
  // Each id has one name: no other spelling of it, nothing behind it, no overflow.
  if (id < 1 || id > kMaxSegmentId || name != NameOf(id)) return std::nullopt;
  return id;
}

Result<std::unique_ptr<SegmentLog>> SegmentLog::Open(const Options& options, const Visitor& visit,
                                                     Recovery& recovery) {
  std::unique_ptr<SegmentLog> log(new SegmentLog(options));
  if (options.directory.empty()) return log;
  std::error_code error;
  std::filesystem::create_directories(options.directory, error);
  if (error) return tl::unexpected(IoError("create", options.directory, error.value()));
  DADRL_RETURN_IF_ERROR(log->Lock());
  RemoveLeftoverTemporaries(options.directory);
  DADRL_RETURN_IF_ERROR(log->Recover(visit, recovery));
  return log;
}

Status SegmentLog::Lock() {
  const auto path = options_.directory / "lock";
  auto file = FileDescriptor::Open(path, O_RDWR | O_CREAT);
  if (!file) file = FileDescriptor::Open(path, O_RDONLY);  // a file system that has become read-only
  DADRL_ASSIGN_OR_RETURN(lock_, std::move(file));
  if (flock(lock_.get(), LOCK_EX | LOCK_NB) == 0) return {};
  if (errno != EWOULDBLOCK) {
    spdlog::warn("{}; only its ports keep a second replay off", IoError("lock", path, errno).message);
    return {};
  }
  return Fail(ErrorCode::kUnavailable,
              "{} is in use by another replay process; stop it or use another run directory",
              options_.directory.string());
}

Status SegmentLog::Recover(const Visitor& visit, Recovery& recovery) {
  std::vector<std::pair<uint64_t, std::filesystem::path>> files;
  std::error_code error;
  for (std::filesystem::directory_iterator it(options_.directory, error), end; !error && it != end;
       it.increment(error)) {
    if (const auto id = IdOf(it->path())) files.emplace_back(*id, it->path());
  }
  if (error) return tl::unexpected(IoError("list", options_.directory, error.value()));
  std::sort(files.begin(), files.end());
  // Not under the lock: the visitor takes its own, and others call us under theirs.
  std::deque<std::shared_ptr<Segment>> segments;
  uint64_t bytes = 0;
  for (const auto& [id, path] : files) {
    const Result<std::shared_ptr<Segment>> opened = Segment::Open(path, id, options_.schema, options_.force);
    if (!opened && opened.error().code == ErrorCode::kCorrupt) return tl::unexpected(opened.error());
    if (!opened && opened.error().code == ErrorCode::kInvalidArgument) {
      ++recovery.refused_files;
      next_id_ = id + 1;  // it stands where a segment of this id would
      spdlog::warn("left alone: {}", opened.error().message);
      continue;
    }
    if (!opened) {
      ++recovery.unreadable;
      next_id_ = id + 1;
      spdlog::warn("{}; this segment is left out", opened.error().message);
      continue;
    }
    const std::shared_ptr<Segment>& segment = *opened;
    const Segment::Scan scan =
        segment->Recover([&](std::span<const std::byte> record) { return visit(segment, record); });
    segment->Seal();
    recovery.dropped_bytes += scan.dropped_bytes;
    recovery.rejected_records += scan.rejected_records;
    if (scan.dropped_bytes > 0 || scan.rejected_records > 0) {
      spdlog::warn("{}: {} records are whole; dropped {} damaged or torn bytes and {} unusable records",
                   path.string(), scan.records, scan.dropped_bytes, scan.rejected_records);
    }
    recovery.unreadable += scan.unreadable ? 1 : 0;
    // What is whole but refused may be good for another configuration: it leaves as the oldest, not before.
    const bool empty = scan.records == 0 && scan.rejected_records == 0;
    if (empty && !scan.unreadable) segment->Unlink();
    if (!empty || std::filesystem::exists(path, error)) next_id_ = id + 1;
    if (empty) continue;
    ++recovery.segments;
    recovery.records += scan.records;
    recovery.bytes += segment->bytes();
    bytes += segment->bytes();
    segments.push_back(segment);
  }
  MutexLock lock(mutex_);
  segments_ = std::move(segments);
  // Whoever wrote them may have died before it forced them.
  unforced_.assign(segments_.begin(), segments_.end());
  names_ = segments_.size();
  bytes_ = bytes;
  return {};
}

std::filesystem::path SegmentLog::PathOf(uint64_t id) const {
  if (options_.directory.empty()) return {};
  return options_.directory / NameOf(id);
}

bool SegmentLog::NeedsSegment(size_t length) const {
  // What is appended to a damaged mapping could not be read back.
  return !open_ || open_->damaged() || !open_->Fits(length);
}

uint64_t SegmentLog::NextSegmentBytes(size_t length) const {
  return std::max(options_.segment_bytes, Segment::HeaderBytes() + Segment::RecordBytes(length));
}

void SegmentLog::CloseSegment() {
  if (!open_) return;
  open_->Seal();
  MutexLock lock(mutex_);
  unforced_.push_back(std::move(open_));
  open_.reset();
}

Status SegmentLog::StartSegment(size_t length) {
  if (next_id_ > kMaxSegmentId) {
    return Fail(ErrorCode::kExhausted, "no segment comes after {} in {}: move the last one away",
                NameOf(kMaxSegmentId), options_.directory.string());
  }
  // The id is taken even when this fails: a file that is half there must not be in the way.
  const uint64_t id = next_id_++;
  DADRL_ASSIGN_OR_RETURN(
      std::shared_ptr<Segment> segment,
      Segment::Create(PathOf(id), id, options_.schema, NextSegmentBytes(length), options_.force));
  open_ = segment;
  MutexLock lock(mutex_);
  segments_.push_back(std::move(segment));
  ++names_;
  bytes_ += Segment::HeaderBytes();
  return {};
}

Result<SegmentLog::Stored> SegmentLog::Append(std::span<const std::byte> record) {
  DADRL_ASSIGN_OR_RETURN(const std::span<const std::byte> bytes, open_->Append(record));
  MutexLock lock(mutex_);
  bytes_ += Segment::RecordBytes(record.size());
  return Stored{open_, bytes};
}

std::vector<SegmentLog::Extent> SegmentLog::Extents() const {
  MutexLock lock(mutex_);
  std::vector<Extent> extents;
  extents.reserve(segments_.size());
  for (const auto& segment : segments_) extents.push_back({segment, segment->bytes(), segment != open_});
  return extents;
}

void SegmentLog::RemoveOldest() {
  MutexLock lock(mutex_);
  if (segments_.empty()) return;
  if (segments_.front() == open_) open_.reset();
  if (!unforced_.empty() && unforced_.front() == segments_.front()) unforced_.pop_front();
  bytes_ -= segments_.front()->bytes();
  segments_.front()->Unlink();
  segments_.pop_front();
}

size_t SegmentLog::segments() const {
  MutexLock lock(mutex_);
  return segments_.size();
}

uint64_t SegmentLog::oldest_id() const {
  MutexLock lock(mutex_);
  return segments_.empty() ? next_id_ : segments_.front()->id();
}

std::shared_ptr<const Segment> SegmentLog::FirstDamaged() const {
  MutexLock lock(mutex_);
  const auto damaged = std::find_if(segments_.begin(), segments_.end(),
                                    [](const auto& segment) { return segment->damaged(); });
  return damaged == segments_.end() ? nullptr : *damaged;
}

uint64_t SegmentLog::bytes() const {
  MutexLock lock(mutex_);
  return bytes_;
}

Status SegmentLog::Sync() {
  std::deque<std::shared_ptr<const Segment>> closed;
  std::shared_ptr<const Segment> newest;
  uint64_t names = 0;
  uint64_t forced_names = 0;
  {
    MutexLock lock(mutex_);
    if (segments_.empty()) return {};
    closed = unforced_;
    newest = segments_.back();
    names = names_;
    forced_names = forced_names_;
  }
  for (const auto& segment : closed) {
    DADRL_RETURN_IF_ERROR(segment->Sync());
    MutexLock lock(mutex_);
    std::erase(unforced_, segment);
  }
  if (closed.empty() || closed.back() != newest) DADRL_RETURN_IF_ERROR(newest->Sync());
  if (names == forced_names || options_.directory.empty()) return {};
  DADRL_RETURN_IF_ERROR(SyncDirectory(options_.directory));
  MutexLock lock(mutex_);
  forced_names_ = std::max(forced_names_, names);
  return {};
}

size_t SegmentLog::unforced() const {
  MutexLock lock(mutex_);
  return unforced_.size();
}

void SegmentLog::DropPagesBeyond(uint64_t bytes) const {
  MutexLock lock(mutex_);
  uint64_t kept = 0;
  for (auto segment = segments_.rbegin(); segment != segments_.rend(); ++segment) {
    kept += (*segment)->bytes();
    if (kept > bytes) (*segment)->DropPages();
  }
}

}  // namespace dadrl
