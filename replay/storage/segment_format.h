// The bytes of a segment file (segment.h), for those that write it and those that only read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace dadrl {

inline constexpr uint32_t kSegmentVersion = 1;
inline constexpr uint64_t kSegmentHeader = 40;
inline constexpr uint64_t kRecordHeader = 24;
// A key holds an id in 32 bits (chunk_index.cpp).
inline constexpr uint64_t kMaxSegmentId = 0xffffffff;
// Of a file: twice what replay.segment_bytes may be. A longer one is not ours.
inline constexpr uint64_t kMaxSegmentBytes = uint64_t{2} << 30;

// Records begin at multiples of 8.
constexpr uint64_t PaddedRecord(uint64_t length) { return (length + 7) / 8 * 8; }

struct SegmentHeader {
  bool whole = false;  // the rest counts only then
  uint32_t version = 0;
  uint64_t id = 0;
  uint64_t schema = 0;
};
std::vector<std::byte> EncodeSegmentHeader(uint64_t id, uint64_t schema);
SegmentHeader ParseSegmentHeader(std::span<const std::byte> file);

// What stands before `content` at `offset` of segment `id`.
std::vector<std::byte> EncodeRecordHeader(uint64_t id, uint64_t offset, std::span<const std::byte> content);

struct SegmentVisitor {
  // A whole record whose content begins at `offset` of the file.
  std::function<void(uint64_t offset, std::span<const std::byte> content)> on_record;
  // `bytes` bytes that belong to no whole record, in the middle or at the end.
  std::function<void(uint64_t offset, uint64_t bytes)> on_damage;
};
// Walks through the records of segment `id`, stepping over what is torn or damaged. Returns the end of the
// last whole one (of the header when there is none, 0 when even that is cut).
uint64_t ScanRecords(std::span<const std::byte> file, uint64_t id, const SegmentVisitor& visitor);

}  // namespace dadrl
