// Tells each actor what is stored and how far it may send.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>

#include "common/dds/endpoint.h"
#include "common/util/clock.h"
#include "common/util/result.h"
#include "proto/topics.h"
#include "replay/sequence_table.h"

namespace dadrl {

// Not thread safe; blocks at most as long as the topic's writer.
class Acknowledger {
 public:
  // An actor hears at most this often, unless it has used half of its grant.
  static constexpr Duration kMinInterval = std::chrono::milliseconds(2);

  // How many chunks beyond the stored ones an actor is granted.
  struct Grant {
    uint64_t chunks = 0;
    bool operator==(const Grant&) const = default;
  };

  static Result<std::unique_ptr<Acknowledger>> Create(const dds::Node& node, uint32_t shard);

  // What is known of an actor; sent by the next Publish, also when it is not news (its last word may have
  // been lost on the way).
  void Note(const SequenceTable::Stream& stream);
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
  };
  using Writers = std::array<std::unique_ptr<dds::Writer<dadrl_idl_Acknowledgement>>, kAcknowledgementGroups>;
  Acknowledger(Writers writers, uint32_t shard) : writers_(std::move(writers)), shard_(shard) {}

  const Writers writers_;
  const uint32_t shard_;
  Grant grant_;
  std::unordered_map<uint32_t, Actor> actors_;
  bool any_due_ = false;
};

}  // namespace dadrl
