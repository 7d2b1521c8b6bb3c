#include "replay/storage/segment_format.h"

#include <algorithm>

#include "common/io/byte_io.h"
#include "common/io/checksum.h"

namespace dadrl {
namespace {

constexpr uint64_t kSegmentMagic = 0x31474553'4c444144;  // "DADLSEG1"
constexpr uint32_t kRecordMagic = 0x44524352;            // "RCRD"

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

struct RecordHeader {
  uint32_t length = 0;
  uint64_t checksum = 0;
};

// True when the record's header at `offset` is whole and its content is inside the file.
bool HeaderAt(std::span<const std::byte> file, uint64_t id, uint64_t offset, RecordHeader& header) {
  if (offset + kRecordHeader > file.size()) return false;
  ByteReader reader(file.subspan(offset, kRecordHeader));
  if (reader.Get<uint32_t>() != kRecordMagic) return false;
  header.length = reader.Get<uint32_t>();
  header.checksum = reader.Get<uint64_t>();
  return reader.Get<uint64_t>() == RecordChecksum(id, offset, header.length, header.checksum) &&
         header.length <= file.size() - offset - kRecordHeader;
}

}  // namespace

std::vector<std::byte> EncodeSegmentHeader(uint64_t id, uint64_t schema) {
  std::vector<std::byte> header;
  ByteWriter writer(header);
  writer.Put(kSegmentMagic);
  writer.Put(kSegmentVersion);
  writer.Put(uint32_t{0});
  writer.Put(id);
  writer.Put(schema);
  AppendChecksum(header);
  return header;
}

SegmentHeader ParseSegmentHeader(std::span<const std::byte> file) {
  if (file.size() < kSegmentHeader) return {};
  ByteReader reader(file);
  const auto magic = reader.Get<uint64_t>();
  SegmentHeader header;
  header.version = reader.Get<uint32_t>();
  reader.Get<uint32_t>();
  header.id = reader.Get<uint64_t>();
  header.schema = reader.Get<uint64_t>();
  header.whole = magic == kSegmentMagic && CheckedContent(file.first(kSegmentHeader));
  return header;
}

std::vector<std::byte> EncodeRecordHeader(uint64_t id, uint64_t offset, std::span<const std::byte> content) {
  const auto length = static_cast<uint32_t>(content.size());
  const uint64_t checksum = Xxh3(content);
  std::vector<std::byte> header;
  header.reserve(kRecordHeader);
  ByteWriter writer(header);
  writer.Put(kRecordMagic);
  writer.Put(length);
  writer.Put(checksum);
  writer.Put(RecordChecksum(id, offset, length, checksum));
  return header;
}

uint64_t ScanRecords(std::span<const std::byte> file, uint64_t id, const SegmentVisitor& visitor) {
  const uint64_t size = file.size();
  if (size < kSegmentHeader) {
    if (size > 0) visitor.on_damage(0, size);
    return 0;
  }
  uint64_t offset = kSegmentHeader;
  uint64_t whole_end = kSegmentHeader;
  while (offset < size) {
    const uint64_t begin = offset;
    RecordHeader header;
    // The next whole record may be anywhere behind the damage.
    while (offset < size && !HeaderAt(file, id, offset, header))
      offset += std::min<uint64_t>(8, size - offset);
    if (offset > begin) visitor.on_damage(begin, offset - begin);
    if (offset == size) break;
    const std::span<const std::byte> content = file.subspan(offset + kRecordHeader, header.length);
    const uint64_t end = std::min(size, offset + kRecordHeader + PaddedRecord(header.length));
    if (Xxh3(content) == header.checksum) {
      visitor.on_record(offset + kRecordHeader, content);
      whole_end = end;
    } else {
      visitor.on_damage(offset, end - offset);
    }
    offset = end;
  }
  return whole_end;
}

}  // namespace dadrl
