// What survives a restart beside the chunks themselves.
#include <cmath>
#include <unordered_map>
#include <utility>

#include "replay/chunk_index.h"
#include "replay/stored_chunk.h"

namespace dadrl {

// False: every item is as good as new after a restart, and there is nothing to remember.
bool ChunkIndex::ItemsDiffer() const {
  return ByPriority(options_.sampler) || options_.max_items > 0 || options_.max_times_sampled > 0;
}

ItemStates ChunkIndex::States() const {
  ItemStates states{.max_priority = max_priority_, .newest_version = newest_version_};
  if (!ItemsDiffer()) return states;
  states.chunks.reserve(chunk_count_);
  states.priorities.reserve(frames_ + chunk_count_);
  states.times_sampled.reserve(frames_ + chunk_count_);
  for (const auto& segment : segments_) {
    for (const StoredChunk& chunk : segment->chunks) {
      states.chunks.push_back(
          {segment->segment->id(), chunk.checksum, static_cast<uint32_t>(chunk.slots().size())});
      for (const uint32_t slot : chunk.slots()) {
        const bool item = StoredChunk::IsItem(slot);
        const float none = slot == StoredChunk::kRemoved ? ItemStates::kRemoved : ItemStates::kNoItem;
        states.priorities.push_back(item ? items_[slot].priority : none);
        states.times_sampled.push_back(item ? items_[slot].times_sampled : 0);
      }
    }
  }
  return states;
}

void ChunkIndex::Restore(const ItemStates& states) {
  SetNewestVersion(states.newest_version);
  if (states.max_priority > max_priority_) {
    max_priority_ = states.max_priority;
    SetAllPriorities(max_priority_);  // those that the states do not know are new
  }
  auto segment = segments_.begin();  // both lists are in the order of the log
  const StoredSegment* indexed = nullptr;
  std::unordered_map<uint64_t, StoredChunk*> chunks;  // of *indexed, by checksum
  size_t frame = 0;                                   // of all
  for (const ItemStates::Chunk& saved : states.chunks) {
    const size_t first = frame;
    frame += saved.frames;
    while (segment != segments_.end() && (*segment)->segment->id() < saved.segment) ++segment;
    if (segment == segments_.end() || (*segment)->segment->id() != saved.segment) continue;
    if (std::exchange(indexed, segment->get()) != segment->get()) {
      chunks.clear();
      for (StoredChunk& chunk : (*segment)->chunks) chunks.emplace(chunk.checksum, &chunk);
    }
    // One that is not here was damaged since it was saved. Each is restored once, whatever the states repeat.
    const auto found = chunks.extract(saved.checksum);
    if (!found || found.mapped()->slots().size() != saved.frames) continue;
    for (size_t i = 0; i < saved.frames; ++i) {
      RestoreItem(*found.mapped(), i, states.priorities[first + i], states.times_sampled[first + i]);
    }
  }
}

void ChunkIndex::RestoreItem(StoredChunk& chunk, size_t frame, float priority, uint32_t times_sampled) {
  const uint32_t slot = chunk.slots()[frame];
  if (!StoredChunk::IsItem(slot) || priority == ItemStates::kNoItem || !std::isfinite(priority)) return;
  const uint32_t limit = options_.max_times_sampled;
  if (priority < 0.0f || (limit > 0 && times_sampled >= limit)) return RemoveItem(slot);
  SetPriority(slot, priority);
  if (limit > 0) samples_left_ -= times_sampled;
  items_[slot].times_sampled = std::min(times_sampled, kMaxTimesSampled);
}

void ChunkIndex::SetAllPriorities(double priority) {
  for (uint32_t slot = 0; slot < items_.size(); ++slot) {
    if (items_[slot].chunk != nullptr) SetPriority(slot, priority);
  }
}

uint64_t ChunkIndex::FramesBehind(LogPosition position) const {
  uint64_t frames = 0;
  for (const auto& stored : segments_) {
    for (const StoredChunk& chunk : stored->chunks) {
      const LogPosition at{stored->segment->id(), stored->segment->OffsetOf(chunk.view.bytes())};
      if (position < at) frames += chunk.decisions();
    }
  }
  return frames;
}

}  // namespace dadrl
