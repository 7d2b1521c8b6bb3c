// Which chunks have been stored: the memory behind "exactly once" and behind acknowledgements.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "common/io/byte_io.h"
#include "proto/experience.h"

namespace dadrl {

// The highest stored sequence of each actor's last incarnations. Bounded: at most kMaxActors actors with
// kMaxIncarnations each. Not thread safe.
class SequenceTable {
 public:
  static constexpr size_t kMaxActors = 65536;
  static constexpr size_t kMaxIncarnations = 4;
  // No actor lives to send so many chunks.
  static constexpr uint64_t kMaxSequence = uint64_t{1} << 48;

  enum class Verdict {
    kNext,        // store it
    kDuplicate,   // stored before
    kGap,         // something before it is still to come: drop it, the actor sends again from there
    kStale,       // of an incarnation that newer ones have pushed out
    kTooMany,     // one actor more than kMaxActors
    kImpossible,  // beyond kMaxSequence
  };
  struct Stream {
    uint32_t actor = 0;
    uint64_t incarnation = 0;
    uint64_t stored = 0;
  };

  // `oldest_kept`: the lowest sequence that the actor can still send, 0 when unknown. What lies between the
  // highest stored and that is lost and skipped; an unknown incarnation that does not say starts anywhere.
  Verdict Check(const ChunkIdentity& identity, uint64_t oldest_kept) const;
  // Stores are contiguous from here on. Returns how many sequences were skipped.
  uint64_t Accept(const ChunkIdentity& identity);

  // Highest stored sequence, nothing for an unknown incarnation.
  std::optional<uint64_t> Stored(uint32_t actor, uint64_t incarnation) const;
  // The newest incarnation of each actor, or of one.
  std::vector<Stream> Newest() const;
  std::optional<Stream> Newest(uint32_t actor) const;

  // Takes the higher of both for every incarnation.
  void Merge(const SequenceTable& other);
  void Put(ByteWriter& writer) const;
  // Nothing when it is cut short, or holds more than a table may: actors, incarnations, sequences.
  static std::optional<SequenceTable> Get(ByteReader& reader);

 private:
  // Incarnation to highest stored sequence.
  using Incarnations = std::map<uint64_t, uint64_t>;
  std::map<uint32_t, Incarnations> actors_;
};

}  // namespace dadrl
