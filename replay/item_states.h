// What an index knows of its items that the stored frames do not say: priorities, times sampled, which have
// left. Travels in the state file.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "common/io/byte_io.h"

namespace dadrl {

struct ItemStates {
  // In place of a priority.
  static constexpr float kNoItem = -1.0f;   // not sampleable yet, or never
  static constexpr float kRemoved = -2.0f;  // was sampleable; has left for good

  struct Chunk {
    uint64_t segment = 0;
    uint64_t checksum = 0;  // its last eight bytes: tells it from every other
    uint32_t frames = 0;
  };

  double max_priority = 1.0;
  uint32_t newest_version = 0;
  // Empty where all items are alike: nothing to remember of them.
  std::vector<Chunk> chunks;            // in the order of the log
  std::vector<float> priorities;        // of all their frames, one after the other
  std::vector<uint32_t> times_sampled;  // likewise

  void Put(ByteWriter& writer) const;
  // Nothing when they are cut short, or hold what no index has had: a priority that is no number or negative,
  // a chunk without frames or of too many, lists of different lengths.
  static std::optional<ItemStates> Get(ByteReader& reader);
};

}  // namespace dadrl
