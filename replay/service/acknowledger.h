// Tells each actor what is stored and how far it may send.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>

#include "common/port/port.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/topics.h"
#include "replay/sequence_table.h"
#include "replay/table.h"

namespace dadrl {

// Not thread safe; blocks at most as long as the topic's writer.
class Acknowledger {
 public:
  // An actor hears at most this often, unless it has used half of its grant.
  static constexpr Duration kMinInterval = std::chrono::milliseconds(2);

  // An actor that was silent for so long has no share in what the chunk reader holds.
  static constexpr Duration kActive = std::chrono::seconds(10);

  // How many chunks beyond the stored ones an actor is granted.
  struct Grant {
    uint64_t chunks = 0;
    bool operator==(const Grant&) const = default;
  };

  static Result<std::unique_ptr<Acknowledger>> Create(const Transport& transport, uint32_t shard);

  // What is known of an actor; sent by the next Publish, also when it is not news (its last word may have
  // been lost on the way).
  void Note(const SequenceTable::Stream& stream);
  // One of its chunks is refused for good; its sender is told with its next word. Note its stream before.
  void Refuse(const ChunkIdentity& identity, const ChunkRefusal& refusal);
  // A chunk of `actor` came.
  void Hear(uint32_t actor, TimePoint now);
  // What each of the actors that are heard may have under way: `window`, or less, so that together they do
  // not fill the chunk reader.
  uint64_t Share(uint64_t window, TimePoint now);
  // Another grant for everybody.
  void SetGrant(Grant grant);
  // Sends what is due. True when more is waiting for its interval to pass.
  bool Publish(TimePoint now);

 private:
  struct Actor {
    uint64_t incarnation = 0;
    uint64_t stored = 0;
    TimePoint sent{};
    uint64_t sent_stored = 0;
    bool due = false;
    uint64_t refused = 0;  // of this incarnation
    uint64_t refused_sequence = 0;
    ChunkRefusal refusal{};
    TimePoint heard{};  // {}: never by this process
  };
  using Writers = std::array<std::unique_ptr<Writer<dadrl_idl_Acknowledgement>>, kAcknowledgementGroups>;
  Acknowledger(Writers writers, uint32_t shard) : writers_(std::move(writers)), shard_(shard) {}

  dadrl_idl_Acknowledgement MessageTo(uint32_t id, const Actor& actor) const;
  Status Send(const dadrl_idl_Acknowledgement& message);

  const Writers writers_;
  const uint32_t shard_;
  Grant grant_;
  std::unordered_map<uint32_t, Actor> actors_;
  bool any_due_ = false;
  size_t active_ = 0;  // as last counted, and those that came since
  TimePoint counted_{};
};

}  // namespace dadrl
