// The table of contents: which frames of the stored chunks can be sampled, and where they are.
#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "common/config/config.h"
#include "common/util/random.h"
#include "proto/experience.h"
#include "replay/item_states.h"
#include "replay/sampling/selector.h"
#include "replay/storage/segment.h"
#include "replay/trajectory_reader.h"

namespace dadrl {

// An item is a frame with a decision whose n-step slice is complete: n frames of its episode follow, or the
// episode's end. The last frames of an episode that breaks off (its actor died, a chunk was lost) never
// become items. With a stride above 1 only every stride-th frame of an episode does: overlapping sequences.
// Not thread safe; reads chunks' columns, never payloads.
class ChunkIndex {
 public:
  struct Options {
    int n_step = 1;  // of the longest slice
    uint32_t stride = 1;
    SamplerKind sampler = SamplerKind::kUniform;
    double priority_exponent = 0.6;
    double importance_exponent = 0.4;
    uint32_t max_times_sampled = 0;  // 0: no limit
    uint32_t max_staleness = 0;      // policy versions behind the newest; 0: no limit
    size_t max_items = 0;            // 0: no limit
    SamplerKind remover = SamplerKind::kOldestFirst;
  };

  explicit ChunkIndex(const Options& options);
  ~ChunkIndex();

  // Chunks come in the order of the log. `chunk` looks into memory of `segment`.
  void Add(const std::shared_ptr<const Segment>& segment, const ChunkView& chunk);
  // Forgets the chunks of segments with a lower id, and their items.
  void DropSegmentsBefore(uint64_t segment);

  // Forgets the items whose slices reach into damaged segments, each segment once; returns how many frames
  // these hold. O(chunks) when there is a new one, otherwise O(segments).
  uint64_t DropDamaged();

  // Items that can be sampled.
  size_t items() const { return selector_->size(); }
  // Samples left until every item has been sampled max_times_sampled times; without that limit, as many as
  // you like once there is an item.
  bool CanSample(size_t count) const;
  // Needs CanSample(count) and n_step of at most the option's.
  SampledItems SampleItems(size_t count, int n_step, Random& random);

  // Lets items beyond max_items leave, as the remover chooses: they are not sampled any more.
  void RemoveSurplus(Random& random);

  // What a restart must know beyond the chunks. O(items), in memory alone.
  ItemStates States() const;
  // After all chunks were added. Chunks that the states do not know, or that are gone, are left alone.
  void Restore(const ItemStates& states);

  // Unknown or dropped keys and priorities that are not finite or negative are ignored.
  void UpdatePriority(uint64_t key, double priority);
  // Drops the items that are too stale by now, if there is a limit.
  void SetNewestVersion(uint32_t version);

  uint64_t frames() const { return frames_; }  // with a decision
  // Of them, those behind `position`.
  uint64_t FramesBehind(LogPosition position) const;
  uint64_t chunks() const { return chunk_count_; }
  // Of what is held now (the vectors behind it keep their largest size).
  size_t memory_bytes() const;

 private:
  static constexpr uint32_t kMaxTimesSampled = (1u << 24) - 1;  // as an Item holds it
  struct StoredChunk;
  struct StoredSegment;
  struct Item {
    StoredChunk* chunk = nullptr;
    float priority = 0.0f;
    uint32_t frame : 8 = 0;
    uint32_t times_sampled : 24 = 0;
  };
  static_assert(sizeof(Item) == 16);
  // The episode an actor is in: what its next chunk may continue.
  struct OpenEpisode {
    uint64_t incarnation = 0;
    uint64_t episode = 0;
    uint32_t next_frame = 0;
    bool truncated = false;       // only the final frame may follow
    StoredChunk* last = nullptr;  // null: nothing to continue
    std::deque<Item> pending;     // frames whose slices are not complete yet
  };

  static uint64_t KeyOf(const StoredChunk& chunk, uint32_t frame);
  OpenEpisode& Continue(StoredChunk& chunk);
  void AddFrames(StoredChunk& chunk, OpenEpisode& episode);
  void Release(OpenEpisode& episode, size_t count);
  void MakeItem(const Item& item);
  void RemoveItem(uint32_t slot);
  void SetPriority(uint32_t slot, double priority);
  void SetAllPriorities(double priority);
  void RestoreItem(StoredChunk& chunk, size_t frame, float priority, uint32_t times_sampled);
  bool ItemsDiffer() const;
  // Of an item that the selector no longer has.
  void FreeSlot(uint32_t slot);
  void RemoveStale(StoredChunk& chunk);
  // Counts a sample against max_times_sampled; true when it was the last: the selector no longer has the
  // item.
  bool CountSample(uint32_t slot);
  bool TooStale(uint32_t policy_version) const;
  void DropOldest();
  void RemoveItems(StoredChunk& chunk);
  // Episodes that are open in it cannot be continued.
  void Abandon(const StoredSegment& segment);
  // Whether a slice that starts in `chunk` may look into a damaged segment.
  bool ReachesDamage(const StoredChunk& chunk) const;
  void AddChunks(const StoredChunk& first, int n_step, SampledItems::Item& item, SampledItems& sampled) const;
  void SetImportance(SampledItems& sampled) const;
  StoredChunk* Find(uint64_t key);

  const Options options_;
  std::unique_ptr<Selector> selector_;
  std::unique_ptr<Selector> remover_;  // only with max_items
  std::deque<std::unique_ptr<StoredSegment>> segments_;
  std::vector<Item> items_;  // by slot
  std::vector<uint32_t> free_slots_;
  std::unordered_map<uint32_t, OpenEpisode> episodes_;  // by actor
  uint64_t frames_ = 0;
  uint64_t chunk_count_ = 0;
  uint64_t sampled_batches_ = 0;  // so far
  uint64_t samples_left_ = 0;     // over all items; counts only with max_times_sampled
  double max_priority_ = 1.0;
  uint32_t newest_version_ = 0;
};

}  // namespace dadrl
