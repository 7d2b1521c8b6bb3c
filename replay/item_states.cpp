#include "replay/item_states.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <span>

#include "proto/experience.h"

namespace dadrl {
namespace {

template <typename T>
std::vector<T> GetVector(ByteReader& reader, uint64_t count) {
  if (count > reader.remaining() / sizeof(T)) count = reader.remaining() + 1;  // more than there is
  const std::span<const std::byte> bytes = reader.GetBytes(count * sizeof(T));
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!bytes.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

bool IsPriority(float value) {
  return value == ItemStates::kNoItem || value == ItemStates::kRemoved ||
         (std::isfinite(value) && value >= 0.0f);
}

}  // namespace

void ItemStates::Put(ByteWriter& writer) const {
  writer.Put(max_priority);
  writer.Put(newest_version);
  writer.Put<uint64_t>(chunks.size());
  writer.Put<uint64_t>(priorities.size());
  for (const Chunk& chunk : chunks) {
    writer.Put(chunk.segment);
    writer.Put(chunk.checksum);
    writer.Put(chunk.frames);
  }
  writer.PutBytes(std::as_bytes(std::span(priorities)));
  writer.PutBytes(std::as_bytes(std::span(times_sampled)));
}

std::optional<ItemStates> ItemStates::Get(ByteReader& reader) {
  ItemStates states;
  states.max_priority = reader.Get<double>();
  states.newest_version = reader.Get<uint32_t>();
  const auto chunks = reader.Get<uint64_t>();
  const auto frames = reader.Get<uint64_t>();
  uint64_t counted = 0;
  bool possible = std::isfinite(states.max_priority) && states.max_priority >= 0.0;
  for (uint64_t i = 0; i < chunks && reader.ok() && possible; ++i) {
    Chunk chunk;
    chunk.segment = reader.Get<uint64_t>();
    chunk.checksum = reader.Get<uint64_t>();
    chunk.frames = reader.Get<uint32_t>();
    counted += chunk.frames;
    possible = chunk.frames >= 1 && chunk.frames <= kMaxChunkFrames;
    states.chunks.push_back(chunk);
  }
  if (!possible || counted != frames) return std::nullopt;
  states.priorities = GetVector<float>(reader, frames);
  states.times_sampled = GetVector<uint32_t>(reader, frames);
  if (!reader.ok() || !std::ranges::all_of(states.priorities, IsPriority)) return std::nullopt;
  return states;
}

}  // namespace dadrl
