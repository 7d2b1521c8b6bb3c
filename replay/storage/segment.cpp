#include "replay/storage/segment.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"
#include "common/io/io_error.h"

namespace dadrl {
namespace {

constexpr uint64_t kSegmentMagic = 0x31474553'4c444144;  // "DADLSEG1"
constexpr uint32_t kSegmentVersion = 1;
constexpr uint64_t kSegmentHeader = 40;
constexpr uint32_t kRecordMagic = 0x44524352;  // "RCRD"
constexpr uint64_t kRecordHeader = 24;

constexpr uint64_t Padded(uint64_t length) { return (length + 7) / 8 * 8; }

uint64_t RecordChecksum(uint64_t segment, uint64_t offset, uint32_t length, uint64_t content) {
  std::vector<std::byte> bytes;
  bytes.reserve(40);
  ByteWriter writer(bytes);
  writer.Put(segment);
  writer.Put(offset);
  writer.Put(kRecordMagic);
  writer.Put(length);
  writer.Put(content);
  return Xxh3(bytes);
}

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

Segment::Segment(std::filesystem::path path, uint64_t id, FileDescriptor file)
    : path_(std::move(path)), id_(id), file_(std::move(file)) {}

Segment::~Segment() {
  if (mapping_ != nullptr) munmap(mapping_, capacity_);
}

uint64_t Segment::RecordBytes(size_t length) { return kRecordHeader + Padded(length); }
uint64_t Segment::HeaderBytes() { return kSegmentHeader; }

Result<std::shared_ptr<Segment>> Segment::Create(const std::filesystem::path& path, uint64_t id,
                                                 uint64_t schema, uint64_t capacity) {
  FileDescriptor file;
  if (path.empty()) {
    file = FileDescriptor(memfd_create("dadrl-replay-segment", MFD_CLOEXEC));
    if (!file.valid()) return tl::unexpected(IoError("create", "memory segment", errno));
  } else {
    DADRL_ASSIGN_OR_RETURN(file, FileDescriptor::Open(path, O_RDWR | O_CREAT | O_EXCL));
  }
  std::shared_ptr<Segment> segment(new Segment(path, id, std::move(file)));
  Status status = segment->Map(capacity);
  if (status) status = segment->WriteHeader(schema);
  if (!status) {
    segment->Unlink();
    return tl::unexpected(std::move(status.error()));
  }
  return segment;
}

Result<std::shared_ptr<Segment>> Segment::Open(const std::filesystem::path& path, uint64_t id,
                                               uint64_t schema) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor file, FileDescriptor::Open(path, O_RDWR));
  struct stat status {};
  if (fstat(file.get(), &status) != 0) return tl::unexpected(IoError("stat", path, errno));
  const auto size = static_cast<uint64_t>(status.st_size);
  std::shared_ptr<Segment> segment(new Segment(path, id, std::move(file)));
  segment->used_ = size;
  if (size < kSegmentHeader) return segment;
  DADRL_RETURN_IF_ERROR(segment->Map(size));
  const std::span<const std::byte> header(segment->mapping_, kSegmentHeader);
  ByteReader reader(header);
  const auto magic = reader.Get<uint64_t>();
  const auto version = reader.Get<uint32_t>();
  reader.Get<uint32_t>();
  reader.Get<uint64_t>();
  const auto file_schema = reader.Get<uint64_t>();
  const bool whole =
      magic == kSegmentMagic && reader.Get<uint64_t>() == Xxh3(header.first(kSegmentHeader - 8));
  if (whole && (version != kSegmentVersion || file_schema != schema)) {
    return Fail(ErrorCode::kCorrupt,
                "{}: holds experience of schema {:#x} (format {}), this run needs {:#x} (format {}): the "
                "observation configuration differs; use another run directory or remove the replay folder",
                path.string(), file_schema, version, schema, kSegmentVersion);
  }
  return segment;
}

Status Segment::Map(uint64_t length) {
  // Beyond the file's end nothing is ever touched, so the mapping may be longer than the file.
  void* mapping = mmap(nullptr, length, PROT_READ, MAP_SHARED, file_.get(), 0);
  if (mapping == MAP_FAILED) return tl::unexpected(IoError("map", path_, errno));
  mapping_ = static_cast<std::byte*>(mapping);
  capacity_ = length;
  return {};
}

Status Segment::WriteHeader(uint64_t schema) {
  std::vector<std::byte> header;
  ByteWriter writer(header);
  writer.Put(kSegmentMagic);
  writer.Put(kSegmentVersion);
  writer.Put(uint32_t{0});
  writer.Put(id_);
  writer.Put(schema);
  writer.Put(Xxh3(header));
  if (!WriteAllAt(file_.get(), {iovec{header.data(), header.size()}, {}, {}}, 0)) {
    return tl::unexpected(IoError("write", path_, errno));
  }
  used_ = kSegmentHeader;
  return {};
}

Result<std::span<const std::byte>> Segment::Append(std::span<const std::byte> content) {
  const auto length = static_cast<uint32_t>(content.size());
  const uint64_t offset = used_;
  const uint64_t checksum = Xxh3(content);
  std::vector<std::byte> header;
  header.reserve(kRecordHeader);
  ByteWriter writer(header);
  writer.Put(kRecordMagic);
  writer.Put(length);
  writer.Put(checksum);
  writer.Put(RecordChecksum(id_, offset, length, checksum));
  std::array<std::byte, 8> zeros{};
  const std::array<iovec, 3> parts = {iovec{header.data(), header.size()},
                                      iovec{const_cast<std::byte*>(content.data()), content.size()},
                                      iovec{zeros.data(), static_cast<size_t>(Padded(length) - length)}};
  // A failed write leaves a torn record behind `used_`: the next one overwrites it, or recovery drops it.
  if (!WriteAllAt(file_.get(), parts, offset)) return tl::unexpected(IoError("write", path_, errno));
  const std::span<const std::byte> stored(mapping_ + offset + kRecordHeader, length);
  used_ = offset + RecordBytes(length);
  return stored;
}

bool Segment::HeaderAt(uint64_t offset, uint32_t& length, uint64_t& content_checksum) const {
  if (offset + kRecordHeader > used_) return false;
  ByteReader reader({mapping_ + offset, kRecordHeader});
  if (reader.Get<uint32_t>() != kRecordMagic) return false;
  length = reader.Get<uint32_t>();
  content_checksum = reader.Get<uint64_t>();
  return reader.Get<uint64_t>() == RecordChecksum(id_, offset, length, content_checksum) &&
         length <= used_ - offset - kRecordHeader;
}

Result<Segment::Scan> Segment::Recover(const Visitor& visit) {
  Scan scan;
  const uint64_t size = used_;
  uint64_t offset = kSegmentHeader;
  uint64_t whole_end = size < kSegmentHeader ? 0 : kSegmentHeader;
  uint64_t dropped = 0;
  while (offset < size) {
    uint32_t length = 0;
    uint64_t checksum = 0;
    if (!HeaderAt(offset, length, checksum)) {
      // Records start at multiples of 8: the next whole one may be anywhere behind the damage.
      const uint64_t step = std::min<uint64_t>(8, size - offset);
      offset += step;
      dropped += step;
      continue;
    }
    const std::span<const std::byte> content(mapping_ + offset + kRecordHeader, length);
    const uint64_t end = std::min(size, offset + RecordBytes(length));
    if (Xxh3(content) == checksum) {
      ++(visit(content) ? scan.records : scan.rejected_records);
      whole_end = end;
    } else {
      dropped += end - offset;
    }
    offset = end;
  }
  if (size < kSegmentHeader) dropped = size;
  scan.dropped_bytes = dropped;
  if (whole_end < size && ftruncate(file_.get(), static_cast<off_t>(whole_end)) != 0) {
    return tl::unexpected(IoError("truncate", path_, errno));
  }
  used_ = whole_end;
  return scan;
}

Status Segment::Sync() const {
  if (path_.empty()) return {};
  return SyncFile(file_, path_);
}

void Segment::DropPages() const {
  if (mapping_ != nullptr && !path_.empty()) madvise(mapping_, capacity_, MADV_DONTNEED);
}

void Segment::Unlink() const {
  if (!path_.empty()) unlink(path_.c_str());
}

}  // namespace dadrl
