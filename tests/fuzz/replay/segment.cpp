// The bytes of a segment file.
#include <cstring>

#include "replay/storage/segment_format.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

constexpr uint64_t kId = 7;
constexpr uint64_t kSchema = 42;

void Append(Bytes& file, std::span<const std::byte> content) {
  const auto header = EncodeRecordHeader(kId, file.size(), content);
  file.insert(file.end(), header.begin(), header.end());
  file.insert(file.end(), content.begin(), content.end());
  file.resize(PaddedRecord(file.size()));
}

Bytes File(std::initializer_list<size_t> lengths) {
  Bytes file = EncodeSegmentHeader(kId, kSchema);
  for (const size_t length : lengths) Append(file, Bytes(length, static_cast<std::byte>(length)));
  return file;
}

}  // namespace

const int kMutants = 100000;

// Records and damage come in order, and are all of the file but headers and padding; each record proves its
// place.
bool Check(std::span<std::byte> input) {
  const std::span<const std::byte> file = input;
  uint64_t behind = 0;
  uint64_t records = 0;
  uint64_t last_record_end = 0;
  const auto on_record = [&](uint64_t offset, std::span<const std::byte> content) {
    Require(offset >= behind + kRecordHeader && offset + content.size() <= file.size());
    Require(content.data() == file.data() + offset);
    const auto header = EncodeRecordHeader(kId, offset - kRecordHeader, content);
    Require(std::memcmp(header.data(), file.data() + offset - kRecordHeader, header.size()) == 0);
    behind = offset + content.size();
    last_record_end = std::min<uint64_t>(file.size(), offset + PaddedRecord(content.size()));
    ++records;
  };
  const auto on_damage = [&](uint64_t offset, uint64_t bytes) {
    Require(offset >= behind && bytes > 0 && bytes <= file.size() - offset);
    behind = offset + bytes;
  };
  const uint64_t end = ScanRecords(file, kId, {.on_record = on_record, .on_damage = on_damage});
  Require(end <= file.size());
  if (records > 0) Require(end == last_record_end);
  const SegmentHeader header = ParseSegmentHeader(file);
  if (header.whole && header.version == kSegmentVersion) {
    const auto again = EncodeSegmentHeader(header.id, header.schema);
    Require(std::memcmp(again.data(), file.data(), 12) == 0);
  }
  return records > 0;
}

Seeds MakeSeeds() {
  Bytes nested = File({40});
  // A record whose content is a record of another place.
  const Bytes other = File({16});
  Append(nested, std::span(other).subspan(kSegmentHeader));
  return {.accepted = {File({1}), File({100, 7, 33}), nested}, .refused = {File({}), {}}};
}

}  // namespace dadrl::fuzz
