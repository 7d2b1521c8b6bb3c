#include "replay/sequence_table.h"

#include <algorithm>

namespace dadrl {

SequenceTable::Verdict SequenceTable::Check(const ChunkIdentity& identity, uint64_t oldest_kept) const {
  if (identity.sequence > kMaxSequence) return Verdict::kImpossible;
  const auto actor = actors_.find(identity.actor);
  if (actor == actors_.end()) {
    if (actors_.size() >= kMaxActors) return Verdict::kTooMany;
    return oldest_kept == 0 || identity.sequence == oldest_kept ? Verdict::kNext : Verdict::kGap;
  }
  const Incarnations& incarnations = actor->second;
  const auto found = incarnations.find(identity.incarnation);
  if (found == incarnations.end()) {
    const bool pushed_out =
        incarnations.size() >= kMaxIncarnations && identity.incarnation < incarnations.begin()->first;
    if (pushed_out) return Verdict::kStale;
    return oldest_kept == 0 || identity.sequence == oldest_kept ? Verdict::kNext : Verdict::kGap;
  }
  const uint64_t next = std::max(found->second + 1, oldest_kept);
  if (identity.sequence <= found->second) return Verdict::kDuplicate;
  return identity.sequence == next ? Verdict::kNext : Verdict::kGap;
}

uint64_t SequenceTable::Accept(const ChunkIdentity& identity) {
  Incarnations& incarnations = actors_[identity.actor];
  uint64_t& stored = incarnations[identity.incarnation];
  const uint64_t skipped = identity.sequence - stored - 1;
  stored = identity.sequence;
  while (incarnations.size() > kMaxIncarnations) incarnations.erase(incarnations.begin());
  return skipped;
}

std::optional<uint64_t> SequenceTable::Stored(uint32_t actor, uint64_t incarnation) const {
  const auto found = actors_.find(actor);
  if (found == actors_.end()) return std::nullopt;
  const auto entry = found->second.find(incarnation);
  if (entry == found->second.end()) return std::nullopt;
  return entry->second;
}

std::vector<SequenceTable::Stream> SequenceTable::Newest() const {
  std::vector<Stream> streams;
  streams.reserve(actors_.size());
  for (const auto& [actor, incarnations] : actors_) {
    const auto& [incarnation, stored] = *incarnations.rbegin();
    streams.push_back({actor, incarnation, stored});
  }
  return streams;
}

std::optional<SequenceTable::Stream> SequenceTable::Newest(uint32_t actor) const {
  const auto found = actors_.find(actor);
  if (found == actors_.end()) return std::nullopt;
  const auto& [incarnation, stored] = *found->second.rbegin();
  return Stream{actor, incarnation, stored};
}

void SequenceTable::Merge(const SequenceTable& other) {
  for (const auto& [actor, incarnations] : other.actors_) {
    for (const auto& [incarnation, stored] : incarnations) {
      uint64_t& mine = actors_[actor][incarnation];
      mine = std::max(mine, stored);
    }
    Incarnations& merged = actors_[actor];
    while (merged.size() > kMaxIncarnations) merged.erase(merged.begin());
  }
}

void SequenceTable::Put(ByteWriter& writer) const {
  uint32_t count = 0;
  for (const auto& [actor, incarnations] : actors_) count += incarnations.size();
  writer.Put(count);
  for (const auto& [actor, incarnations] : actors_) {
    for (const auto& [incarnation, stored] : incarnations) {
      writer.Put(actor);
      writer.Put(incarnation);
      writer.Put(stored);
    }
  }
}

std::optional<SequenceTable> SequenceTable::Get(ByteReader& reader) {
  SequenceTable table;
  const auto count = reader.Get<uint32_t>();
  for (uint32_t i = 0; i < count && reader.ok(); ++i) {
    const auto actor = reader.Get<uint32_t>();
    const auto incarnation = reader.Get<uint64_t>();
    const auto stored = reader.Get<uint64_t>();
    Incarnations& incarnations = table.actors_[actor];
    incarnations[incarnation] = stored;
    if (stored > kMaxSequence || incarnations.size() > kMaxIncarnations) return std::nullopt;
    if (table.actors_.size() > kMaxActors) return std::nullopt;
  }
  if (!reader.ok()) return std::nullopt;
  return table;
}

}  // namespace dadrl
