#include "replay/chunk_index.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include "common/util/prefetch.h"
#include "replay/stored_chunk.h"

namespace dadrl {
namespace {

// A key is segment id, chunk within it, frame within that: unique for ever, found without a map.
constexpr int kFrameBits = 6;
constexpr int kChunkBits = 26;
static_assert(kMaxChunkFrames <= 1 << kFrameBits);

}  // namespace

ChunkIndex::ChunkIndex(const Options& options)
    : options_(options), selector_(MakeSelector(options.sampler, options.priority_exponent)) {
  if (options.max_items > 0) remover_ = MakeSelector(options.remover, options.priority_exponent);
}
ChunkIndex::~ChunkIndex() = default;

uint64_t ChunkIndex::KeyOf(const StoredChunk& chunk, uint32_t frame) {
  return (chunk.segment->segment->id() << kChunkBits | chunk.number) << kFrameBits | frame;
}

void ChunkIndex::Add(const std::shared_ptr<const Segment>& segment, const ChunkView& chunk) {
  if (segments_.empty() || segments_.back()->segment != segment) {
    segments_.push_back(std::make_unique<StoredSegment>());
    segments_.back()->segment = segment;
  }
  StoredSegment& home = *segments_.back();
  StoredChunk& stored = home.chunks.emplace_back(chunk, home, home.chunks.size());
  ++chunk_count_;
  AddFrames(stored, Continue(stored));
}

ChunkIndex::OpenEpisode& ChunkIndex::Continue(StoredChunk& chunk) {
  const ChunkHeader header = chunk.view.header();
  OpenEpisode& episode = episodes_[header.identity.actor];
  const bool starts_with_final = (chunk.view.flags(0) & kHasDecision) == 0;
  const bool continues = episode.last != nullptr && episode.incarnation == header.identity.incarnation &&
                         episode.episode == header.episode && episode.next_frame == header.first_frame &&
                         episode.truncated == starts_with_final;
  if (continues) {
    episode.last->next = &chunk;
  } else {
    episode.pending.clear();
    episode.incarnation = header.identity.incarnation;
    episode.episode = header.episode;
  }
  episode.last = &chunk;
  episode.next_frame = header.first_frame + header.frames;
  return episode;
}

void ChunkIndex::AddFrames(StoredChunk& chunk, OpenEpisode& episode) {
  uint8_t flags = 0;
  for (uint8_t frame = 0; frame < chunk.view.frames(); ++frame) {
    flags = chunk.view.flags(frame);
    if ((flags & kHasDecision) == 0) {
      Release(episode, episode.pending.size());
      continue;
    }
    chunk.oldest_version = std::min(chunk.oldest_version, chunk.view.policy_version(frame));
    // This frame is the observation that slices which end here bootstrap from.
    if (std::cmp_equal(episode.pending.size(), options_.n_step)) Release(episode, 1);
    episode.pending.push_back({.chunk = &chunk, .frame = frame});
    if ((flags & kTerminated) != 0) Release(episode, episode.pending.size());
  }
  frames_ += chunk.decisions();
  episode.truncated = (flags & kTruncated) != 0;
  const bool ended = (flags & kHasDecision) == 0 || (flags & kTerminated) != 0;
  if (ended) episode.last = nullptr;
}

void ChunkIndex::Release(OpenEpisode& episode, size_t count) {
  for (; count > 0; --count) {
    MakeItem(episode.pending.front());
    episode.pending.pop_front();
  }
}

void ChunkIndex::MakeItem(const Item& item) {
  const uint32_t frame = item.chunk->view.header().first_frame + item.frame;
  if (frame % options_.stride != 0) return;
  if (TooStale(item.chunk->view.policy_version(item.frame))) {
    item.chunk->slots()[item.frame] = StoredChunk::kRemoved;
    return;
  }
  uint32_t slot = items_.size();
  if (free_slots_.empty()) {
    items_.push_back(item);
  } else {
    slot = free_slots_.back();
    free_slots_.pop_back();
    items_[slot] = item;
  }
  items_[slot].priority = max_priority_;
  item.chunk->slots()[item.frame] = slot;
  selector_->Insert(slot, max_priority_);
  if (remover_) remover_->Insert(slot, max_priority_);
  samples_left_ += options_.max_times_sampled;
}

void ChunkIndex::RemoveItem(uint32_t slot) {
  selector_->Delete(slot);
  FreeSlot(slot);
}

void ChunkIndex::FreeSlot(uint32_t slot) {
  Item& item = items_[slot];
  if (remover_) remover_->Delete(slot);
  samples_left_ -= options_.max_times_sampled - (options_.max_times_sampled > 0 ? item.times_sampled : 0);
  item.chunk->slots()[item.frame] = StoredChunk::kRemoved;
  item = {};
  free_slots_.push_back(slot);
}

void ChunkIndex::DropSegmentsBefore(uint64_t segment) {
  while (!segments_.empty() && segments_.front()->segment->id() < segment) DropOldest();
}

void ChunkIndex::RemoveItems(StoredChunk& chunk) {
  for (const uint32_t slot : chunk.slots()) {
    if (StoredChunk::IsItem(slot)) RemoveItem(slot);
  }
}

// Its first frames are gone; those pending in later segments may go on.
void ChunkIndex::Abandon(const StoredSegment& segment) {
  for (auto& [actor, episode] : episodes_) {
    if (episode.last != nullptr && episode.last->segment == &segment) episode.last = nullptr;
    std::erase_if(episode.pending, [&](const Item& item) { return item.chunk->segment == &segment; });
  }
}

void ChunkIndex::DropOldest() {
  StoredSegment& oldest = *segments_.front();
  Abandon(oldest);
  for (StoredChunk& chunk : oldest.chunks) {
    RemoveItems(chunk);
    if (!oldest.damaged) frames_ -= chunk.decisions();
  }
  chunk_count_ -= oldest.chunks.size();
  segments_.pop_front();
}

uint64_t ChunkIndex::DropDamaged() {
  const uint64_t before = frames_;
  for (const auto& segment : segments_) {
    if (segment->damaged || !segment->segment->damaged()) continue;
    segment->damaged = true;
    Abandon(*segment);
    for (const StoredChunk& chunk : segment->chunks) frames_ -= chunk.decisions();
  }
  if (frames_ == before) return 0;
  for (const auto& segment : segments_) {
    for (StoredChunk& chunk : segment->chunks) {
      if (ReachesDamage(chunk)) RemoveItems(chunk);
    }
  }
  return before - frames_;
}

bool ChunkIndex::ReachesDamage(const StoredChunk& chunk) const {
  int left = options_.n_step;
  for (const StoredChunk* reached = &chunk; reached != nullptr && left > 0; reached = reached->next) {
    if (reached->segment->damaged) return true;
    if (reached != &chunk) left -= reached->view.frames();
  }
  return false;
}

bool ChunkIndex::CanSample(size_t count) const {
  return items() > 0 && (options_.max_times_sampled == 0 || samples_left_ >= count);
}

SampledItems ChunkIndex::SampleItems(size_t count, int n_step, Random& random) {
  assert(CanSample(count) && n_step >= 1 && n_step <= options_.n_step);
  // Memory is slower than all that is done here: each pass asks for what the next one reads.
  std::vector<Selector::Choice> choices(count);
  std::vector<uint32_t> spent;
  if (options_.max_times_sampled == 0) {
    selector_->SampleMany(random, choices);
  } else {
    for (Selector::Choice& choice : choices) {
      choice = selector_->Sample(random);
      if (CountSample(choice.slot)) spent.push_back(choice.slot);
    }
  }
  for (const auto& choice : choices) Prefetch(&items_[choice.slot], sizeof(Item));
  for (const auto& choice : choices) Prefetch(items_[choice.slot].chunk, sizeof(StoredChunk));
  SampledItems sampled;
  sampled.items.resize(count);
  sampled.chunks.reserve(2 * count);
  ++sampled_batches_;
  for (size_t i = 0; i < count; ++i) {
    Item& item = items_[choices[i].slot];
    if (options_.max_times_sampled == 0 && item.times_sampled < kMaxTimesSampled) ++item.times_sampled;
    // Never 0, which nothing that was sampled has: importance divides by it.
    sampled.items[i].probability = std::max<float>(choices[i].probability, std::numeric_limits<float>::min());
    sampled.items[i].frame = item.frame;
    sampled.items[i].key = KeyOf(*item.chunk, item.frame);
    AddChunks(*item.chunk, n_step, sampled.items[i], sampled);
  }
  for (const uint32_t slot : spent) FreeSlot(slot);
  SetImportance(sampled);
  return sampled;
}

bool ChunkIndex::CountSample(uint32_t slot) {
  Item& item = items_[slot];
  --samples_left_;
  if (++item.times_sampled < options_.max_times_sampled) return false;
  selector_->Delete(slot);
  return true;
}

// The chunks that hold the frames of `item` and `n_step` more, as far as the episode goes.
void ChunkIndex::AddChunks(const StoredChunk& first, int n_step, SampledItems::Item& item,
                           SampledItems& sampled) const {
  item.first_chunk = sampled.chunks.size();
  int left = item.frame + n_step + 1;
  for (const StoredChunk* chunk = &first; chunk != nullptr && left > 0; chunk = chunk->next) {
    sampled.chunks.push_back(chunk->view);
    left -= chunk->view.frames();
    if (std::exchange(chunk->segment->last_batch, sampled_batches_) != sampled_batches_) {
      sampled.segments.push_back(chunk->segment->segment);
    }
  }
  item.chunk_count = sampled.chunks.size() - item.first_chunk;
}

// (N P)^-beta, scaled so that the largest of the batch is 1 (Schaul et al., 2016).
void ChunkIndex::SetImportance(SampledItems& sampled) const {
  if (options_.sampler != SamplerKind::kPrioritized) return;
  double least = std::numeric_limits<double>::max();
  for (const auto& item : sampled.items) least = std::min<double>(least, item.probability);
  for (auto& item : sampled.items) {
    item.importance_weight = std::pow(least / item.probability, options_.importance_exponent);
  }
}

ChunkIndex::StoredChunk* ChunkIndex::Find(uint64_t key) {
  const uint64_t id = key >> (kChunkBits + kFrameBits);
  const uint64_t number = key >> kFrameBits & ((uint64_t{1} << kChunkBits) - 1);
  const auto found =
      std::lower_bound(segments_.begin(), segments_.end(), id,
                       [](const auto& stored, uint64_t wanted) { return stored->segment->id() < wanted; });
  if (found == segments_.end() || (*found)->segment->id() != id) return nullptr;
  auto& chunks = (*found)->chunks;
  return number < chunks.size() ? &chunks[number] : nullptr;
}

void ChunkIndex::UpdatePriority(uint64_t key, double priority) {
  if (!std::isfinite(priority) || priority < 0.0) return;
  StoredChunk* chunk = Find(key);
  const uint64_t frame = key & ((uint64_t{1} << kFrameBits) - 1);
  if (chunk == nullptr || frame >= chunk->slots().size()) return;
  const uint32_t slot = chunk->slots()[frame];
  if (!StoredChunk::IsItem(slot)) return;
  max_priority_ = std::max(max_priority_, priority);
  SetPriority(slot, priority);
}

void ChunkIndex::SetPriority(uint32_t slot, double priority) {
  items_[slot].priority = priority;
  selector_->Update(slot, priority);
  if (remover_) remover_->Update(slot, priority);
}

void ChunkIndex::RemoveSurplus(Random& random) {
  while (remover_ && items() > options_.max_items) RemoveItem(remover_->Sample(random).slot);
}

bool ChunkIndex::TooStale(uint32_t policy_version) const {
  const uint32_t limit = options_.max_staleness;
  return limit > 0 && newest_version_ > policy_version && newest_version_ - policy_version > limit;
}

void ChunkIndex::SetNewestVersion(uint32_t version) {
  if (version <= newest_version_) return;
  newest_version_ = version;
  if (options_.max_staleness == 0) return;
  for (const auto& segment : segments_) {
    for (StoredChunk& chunk : segment->chunks) RemoveStale(chunk);
  }
}

void ChunkIndex::RemoveStale(StoredChunk& chunk) {
  if (!TooStale(chunk.oldest_version)) return;
  uint32_t oldest_left = std::numeric_limits<uint32_t>::max();
  for (uint8_t frame = 0; frame < chunk.view.frames(); ++frame) {
    if ((chunk.view.flags(frame) & kHasDecision) == 0) continue;
    const uint32_t version = chunk.view.policy_version(frame);
    const uint32_t slot = chunk.slots()[frame];
    if (!TooStale(version)) {
      oldest_left = std::min(oldest_left, version);
    } else if (StoredChunk::IsItem(slot)) {
      RemoveItem(slot);
    }
  }
  chunk.oldest_version = oldest_left;
}

size_t ChunkIndex::memory_bytes() const {
  constexpr size_t kHeapOverhead = 16;  // of one allocation
  const size_t chunks = chunk_count_ * (sizeof(StoredChunk) + kHeapOverhead);
  const size_t slots = frames_ * sizeof(uint32_t);
  const size_t item = sizeof(Item) + sizeof(uint32_t) + selector_->bytes_per_item() +
                      (remover_ ? remover_->bytes_per_item() : 0);
  return chunks + slots + items() * item;
}

}  // namespace dadrl
