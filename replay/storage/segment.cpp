#include "replay/storage/segment.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "common/io/io_error.h"
#include "common/io/unnamed_file.h"
#include "replay/storage/segment_format.h"

namespace dadrl {
namespace {

// Writes all parts at `offset`; false with errno set.
bool WriteAllAt(int fd, std::array<iovec, 3> parts, uint64_t offset) {
  size_t first = 0;
  while (first < parts.size()) {
    const ssize_t written =
        pwritev(fd, &parts[first], static_cast<int>(parts.size() - first), static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      return false;
    }
    offset += static_cast<uint64_t>(written);
    auto left = static_cast<size_t>(written);
    while (first < parts.size() && left >= parts[first].iov_len) left -= parts[first++].iov_len;
    if (first < parts.size()) {
      parts[first].iov_base = static_cast<std::byte*>(parts[first].iov_base) + left;
      parts[first].iov_len -= left;
    }
  }
  return true;
}

}  // namespace

Segment::Segment(std::filesystem::path path, uint64_t id, FileDescriptor file, Force force)
    : path_(std::move(path)),
      id_(id),
      file_(std::make_shared<const FileDescriptor>(std::move(file))),
      force_(std::move(force)) {}

uint64_t Segment::RecordBytes(size_t length) { return kRecordHeader + PaddedRecord(length); }
uint64_t Segment::HeaderBytes() { return kSegmentHeader; }

Result<std::shared_ptr<Segment>> Segment::Create(const std::filesystem::path& path, uint64_t id,
                                                 uint64_t schema, uint64_t capacity, Force force) {
  FileDescriptor file;
  if (path.empty()) {
    DADRL_ASSIGN_OR_RETURN(file, OpenUnnamedFile("dadrl-replay-segment"));
  } else {
    DADRL_ASSIGN_OR_RETURN(file, FileDescriptor::Open(path, O_RDWR | O_CREAT | O_EXCL));
  }
  std::shared_ptr<Segment> segment(new Segment(path, id, std::move(file), std::move(force)));
  Status status = segment->Map(capacity);
  if (status) status = segment->WriteHeader(schema);
  if (!status) {
    segment->Unlink();
    return tl::unexpected(std::move(status.error()));
  }
  return segment;
}

Result<std::shared_ptr<Segment>> Segment::Open(const std::filesystem::path& path, uint64_t id,
                                               uint64_t schema, Force force) {
  auto opened = FileDescriptor::Open(path, O_RDWR);
  if (!opened) opened = FileDescriptor::Open(path, O_RDONLY);
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, std::move(opened));
  struct stat status {};
  if (fstat(file.get(), &status) != 0) return tl::unexpected(IoError("stat", path, errno));
  const auto size = static_cast<uint64_t>(status.st_size);
  if (size > kMaxSegmentBytes) {
    return Fail(ErrorCode::kInvalidArgument, "{} is {} bytes long, a segment at most {}: move it away",
                path.string(), size, kMaxSegmentBytes);
  }
  std::shared_ptr<Segment> segment(new Segment(path, id, std::move(file), std::move(force)));
  segment->used_ = size;
  if (size < kSegmentHeader) return segment;
  DADRL_RETURN_IF_ERROR(segment->Map(size));
  const SegmentHeader header = ParseSegmentHeader(segment->Prefix(size));
  if (header.whole && (header.version != kSegmentVersion || header.schema != schema)) {
    return Fail(ErrorCode::kCorrupt,
                "{}: holds experience of schema {:#x} (format {}), this run needs {:#x} (format {}): "
                "its columns differ; use another run directory or remove the replay folder",
                path.string(), header.schema, header.version, schema, kSegmentVersion);
  }
  return segment;
}

Status Segment::Map(uint64_t length) {
  // Beyond the file's end nothing is ever touched, so the mapping may be longer than the file.
  DADRL_ASSIGN_OR_RETURN(mapping_, GuardedMapping::Map(AppendedFile(), length, path_));
  capacity_ = length;
  return {};
}

Status Segment::WriteHeader(uint64_t schema) {
  std::vector<std::byte> header = EncodeSegmentHeader(id_, schema);
  if (!WriteAllAt(AppendedFile().get(), {iovec{header.data(), header.size()}, {}, {}}, 0)) {
    return tl::unexpected(IoError("write", path_, errno));
  }
  used_ = kSegmentHeader;
  return {};
}

Result<std::span<const std::byte>> Segment::Append(std::span<const std::byte> content) {
  const uint64_t length = content.size();
  const uint64_t offset = used_;
  std::vector<std::byte> header = EncodeRecordHeader(id_, offset, content);
  std::array<std::byte, 8> zeros{};
  const std::array<iovec, 3> parts = {iovec{header.data(), header.size()},
                                      iovec{const_cast<std::byte*>(content.data()), content.size()},
                                      iovec{zeros.data(), PaddedRecord(length) - length}};
  if (!WriteAllAt(AppendedFile().get(), parts, offset)) {
    Error error = IoError("write", path_, errno);
    // Half a record would look like damage. Should this fail as well, the next record overwrites it, or
    // recovery drops it.
    [[maybe_unused]] const int cut = ftruncate(AppendedFile().get(), static_cast<off_t>(offset));
    return tl::unexpected(std::move(error));
  }
  const std::span<const std::byte> stored = mapping_.bytes().subspan(offset + kRecordHeader, length);
  used_ = offset + RecordBytes(length);
  return stored;
}

Segment::Scan Segment::Recover(const Visitor& visit) {
  Scan scan;
  const auto on_record = [&](uint64_t, std::span<const std::byte> content) {
    ++(visit(content) ? scan.records : scan.rejected_records);
  };
  const auto on_damage = [&](uint64_t, uint64_t bytes) { scan.dropped_bytes += bytes; };
  const uint64_t size = used_;
  // A file too short for its header is not mapped: all of it is damage.
  const bool mapped = !mapping_.bytes().empty();
  if (!mapped) on_damage(0, size);
  const uint64_t whole_end =
      mapped ? ScanRecords(Prefix(size), id_, {.on_record = on_record, .on_damage = on_damage}) : 0;
  // A tail that stays where nothing can be written is stepped over by the next start as well. What only
  // cannot be read now is left alone.
  scan.unreadable = damaged();
  if (whole_end < size && !scan.unreadable) {
    [[maybe_unused]] const int cut = ftruncate(AppendedFile().get(), static_cast<off_t>(whole_end));
  }
  mapping_.ForgetDamage();
  used_ = whole_end;
  return scan;
}

void Segment::Seal() {
  MutexLock lock(file_mutex_);
  file_.reset();
}

Result<Segment::SharedFile> Segment::File() const {
  {
    MutexLock lock(file_mutex_);
    if (file_) return file_;
  }
  auto again = FileDescriptor::Open(path_, O_RDWR);
  if (!again) again = FileDescriptor::Open(path_, O_RDONLY);
  return std::move(again).map(
      [](FileDescriptor&& file) { return std::make_shared<const FileDescriptor>(std::move(file)); });
}

Status Segment::Sync() const {
  if (path_.empty()) return {};
  MutexLock lock(sync_mutex_);
  if (damaged() || unlinked_.load()) return {};
  const Result<SharedFile> file = File();
  // Removed meanwhile?
  if (!file) return unlinked_.load() ? Status() : tl::unexpected(file.error());
  Status forced = failed_ ? WriteAgain(**file) : Status();
  if (forced) forced = force_(**file, path_);
  failed_ = !forced;
  return forced;
}

// What is appended meanwhile lies behind it, and is written for the first time.
Status Segment::WriteAgain(const FileDescriptor& file) const {
  constexpr uint64_t kPiece = uint64_t{1} << 20;
  const std::span<const std::byte> all = Prefix(used_);
  std::vector<std::byte> piece;
  for (uint64_t offset = 0; offset < all.size(); offset += piece.size()) {
    const auto next = all.subspan(offset, std::min<uint64_t>(kPiece, all.size() - offset));
    piece.assign(next.begin(), next.end());
    if (damaged()) return {};  // zeros are no better than what is there
    if (!WriteAllAt(file.get(), {iovec{piece.data(), piece.size()}, {}, {}}, offset)) {
      return tl::unexpected(IoError("write", path_, errno));
    }
  }
  return {};
}

void Segment::DropPages() const {
  if (path_.empty() || mapping_.bytes().empty()) return;
  madvise(const_cast<std::byte*>(mapping_.bytes().data()), capacity_, MADV_DONTNEED);
}

void Segment::Unlink() {
  unlinked_.store(true);
  if (!path_.empty()) unlink(path_.c_str());
}

}  // namespace dadrl
