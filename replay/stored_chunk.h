// What the index keeps of each stored chunk; shared by its own source files only.
#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <vector>

#include "replay/chunk_index.h"

namespace dadrl {

struct ChunkIndex::StoredChunk {
  ChunkView view;
  uint64_t offset = 0;  // within the segment
  uint64_t checksum = 0;
  StoredSegment* segment = nullptr;
  uint32_t number = 0;          // within the segment
  uint32_t actions = 0;         // frames with one
  uint32_t oldest_version = 0;  // of the policies that acted in it
  StoredChunk* next = nullptr;  // of the same episode; never older, so it is not dropped before this one
  // By frame: its item's slot, or one of the two below.
  std::vector<uint32_t> slots;

  static constexpr uint32_t kNoItem = std::numeric_limits<uint32_t>::max();
  static constexpr uint32_t kRemoved = kNoItem - 1;
  static bool IsItem(uint32_t slot) { return slot < kRemoved; }
};

struct ChunkIndex::StoredSegment {
  std::shared_ptr<const Segment> segment;
  std::deque<StoredChunk> chunks;
};

}  // namespace dadrl
