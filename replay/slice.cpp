#include "replay/slice.h"

#include <optional>
#include <utility>

namespace dadrl {
namespace {

// A position in an episode, over the chunks of one item.
struct Cursor {
  std::span<const ChunkView> chunks;
  int frame = 0;

  const ChunkView& chunk() const { return chunks.front(); }
  bool Advance() {
    if (++frame < chunk().frames()) return true;
    chunks = chunks.subspan(1);
    frame = 0;
    return !chunks.empty();
  }
};

// Nothing when the offsets do not fit the chunk: it was sound when it was stored.
std::optional<std::span<const std::byte>> Payload(const Cursor& at) {
  const uint32_t begin = at.chunk().offset(at.frame);
  const uint32_t end = at.chunk().offset(at.frame + 1);
  if (begin >= end || end > at.chunk().payload_bytes()) return std::nullopt;
  const std::span<const std::byte> payload = at.chunk().payload(at.frame);
  // It reads the offsets anew: a failing disk may change them at any time.
  if (payload.size() != end - begin) return std::nullopt;
  return payload;
}

// Fills `item` with up to `n_step` steps; their rewards go to the end of `rewards`. False when the stored
// bytes make no slice.
bool Assemble(Cursor at, int n_step, SampledItem& item, std::vector<float>& rewards) {
  const auto first = Payload(at);
  if (!first) return false;
  item.first = *first;
  item.policy_version = at.chunk().policy_version(at.frame);
  item.action = at.chunk().action(at.frame);
  for (int step = 1; step <= n_step; ++step) {
    const uint8_t flags = at.chunk().flags(at.frame);
    if ((flags & kHasAction) == 0) return false;
    rewards.push_back(at.chunk().reward(at.frame));
    item.terminated = (flags & kTerminated) != 0;
    if (item.terminated) return true;
    if (!at.Advance()) return false;
    const bool final_frame = (at.chunk().flags(at.frame) & kHasAction) == 0;
    if (final_frame != ((flags & kTruncated) != 0)) return false;
    if (final_frame) break;
  }
  const auto next = Payload(at);
  if (next) item.next = *next;
  return next.has_value();
}

// Fills `sequence` with up to `length` steps and the frames around them. False when the stored bytes make
// none.
bool AssembleSequence(Cursor at, int length, SampledSequence& sequence) {
  for (int step = 0; step < length; ++step) {
    const auto frame = Payload(at);
    const uint8_t flags = at.chunk().flags(at.frame);
    if (!frame || (flags & kHasAction) == 0) return false;
    sequence.frames.push_back(*frame);
    sequence.steps.push_back(
        {at.chunk().policy_version(at.frame), at.chunk().action(at.frame), at.chunk().reward(at.frame)});
    sequence.terminated = (flags & kTerminated) != 0;
    sequence.truncated = (flags & kTruncated) != 0;
    if (sequence.terminated) return true;
    if (!at.Advance()) return false;
    const bool final_frame = (at.chunk().flags(at.frame) & kHasAction) == 0;
    if (final_frame != sequence.truncated) return false;
    if (final_frame) break;
  }
  const auto behind = Payload(at);
  if (behind) sequence.frames.push_back(*behind);
  return behind.has_value();
}

tl::unexpected<Error> Changed(uint64_t key) {
  return Fail(ErrorCode::kCorrupt, "stored frame {:#x} has changed since it was checked: the disk is failing",
              key);
}

}  // namespace

Result<SampledBatch> AssembleBatch(DrawnItems drawn, int n_step) {
  SampledBatch batch;
  batch.segments = std::move(drawn.segments);
  batch.items.resize(drawn.items.size());
  // Never grows beyond this, so the items' spans stay where they are.
  batch.rewards.reserve(drawn.items.size() * static_cast<size_t>(n_step));
  const std::span<const ChunkView> chunks(drawn.chunks);
  // Most of it is not in the processor's caches: ask for all before any of it is read.
  for (const DrawnItems::Item& item : drawn.items) chunks[item.first_chunk].PrefetchColumns(item.frame);
  for (size_t i = 0; i < drawn.items.size(); ++i) {
    const DrawnItems::Item& from = drawn.items[i];
    SampledItem& item = batch.items[i];
    item.key = from.key;
    item.probability = from.probability;
    item.importance_weight = from.importance_weight;
    const size_t first_reward = batch.rewards.size();
    const Cursor start{chunks.subspan(from.first_chunk, from.chunk_count), from.frame};
    if (!Assemble(start, n_step, item, batch.rewards)) {
      return Changed(from.key);
    }
    item.rewards = std::span(batch.rewards).subspan(first_reward);
  }
  return batch;
}

Result<SampledSequences> AssembleSequences(DrawnItems drawn, int length) {
  SampledSequences batch;
  batch.segments = std::move(drawn.segments);
  batch.sequences.reserve(drawn.items.size());
  const std::span<const ChunkView> chunks(drawn.chunks);
  for (const DrawnItems::Item& from : drawn.items) {
    SampledSequence& sequence = batch.sequences.emplace_back();
    sequence.key = from.key;
    sequence.probability = from.probability;
    sequence.importance_weight = from.importance_weight;
    const Cursor start{chunks.subspan(from.first_chunk, from.chunk_count), from.frame};
    if (!AssembleSequence(start, length, sequence)) return Changed(from.key);
  }
  return batch;
}

Status CheckReadable(const std::vector<std::shared_ptr<const Segment>>& segments) {
  for (const auto& segment : segments) {
    if (segment->damaged()) return Fail(ErrorCode::kCorrupt, "cannot read {}", segment->path().string());
  }
  return {};
}

}  // namespace dadrl
