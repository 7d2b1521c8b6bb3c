// What the index keeps of each stored chunk; shared by its own source files only.
#pragma once

#include <algorithm>
#include <deque>
#include <limits>
#include <memory>
#include <span>

#include "replay/chunk_index.h"

namespace dadrl {

// One cache line: a sample reads one of these at random.
struct alignas(64) ChunkIndex::StoredChunk {
  static constexpr uint32_t kNoItem = std::numeric_limits<uint32_t>::max();
  static constexpr uint32_t kRemoved = kNoItem - 1;
  static bool IsItem(uint32_t slot) { return slot < kRemoved; }

  StoredChunk(const ChunkView& chunk, StoredSegment& home, uint32_t number_within)
      : view(chunk),
        segment(&home),
        slots_by_frame(std::make_unique<uint32_t[]>(static_cast<size_t>(chunk.frames()))),
        checksum(chunk.checksum()),
        number(number_within),
        ends_with_final((chunk.flags(chunk.frames() - 1) & kHasDecision) == 0 ? 1 : 0) {
    std::fill_n(slots_by_frame.get(), chunk.frames(), kNoItem);
  }

  // By frame: its item's slot, or kNoItem, or kRemoved.
  std::span<uint32_t> slots() { return {slots_by_frame.get(), static_cast<size_t>(view.frames())}; }
  std::span<const uint32_t> slots() const {
    return {slots_by_frame.get(), static_cast<size_t>(view.frames())};
  }
  // Frames with a decision: all but a final observation.
  uint64_t decisions() const { return static_cast<uint64_t>(view.frames()) - ends_with_final; }

  ChunkView view;
  StoredSegment* segment;
  StoredChunk* next = nullptr;  // of the same episode; never older, so it is not dropped before this one
  std::unique_ptr<uint32_t[]> slots_by_frame;
  uint64_t checksum;
  uint32_t number : 31;  // within the segment
  uint32_t ends_with_final : 1;
  uint32_t oldest_version = std::numeric_limits<uint32_t>::max();  // of the policies that acted in it
};

struct ChunkIndex::StoredSegment {
  static_assert(sizeof(StoredChunk) == 64);

  std::shared_ptr<const Segment> segment;
  std::deque<StoredChunk> chunks;
  uint64_t last_batch = 0;  // the last that holds it
  bool damaged = false;     // nothing of it is sampled any more, and its frames are not counted
};

}  // namespace dadrl
