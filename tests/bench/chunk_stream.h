// As many different chunks as one likes from a few: their payloads repeat, their identities do not.
#pragma once

#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "common/io/checksum.h"
#include "tests/proto/synthetic_experience.h"

namespace dadrl::bench {

class ChunkStream {
 public:
  static constexpr int kFrames = 64;

  explicit ChunkStream(const ObservationSpec& spec) {
    for (uint64_t seed = 0; seed < kDistinct; ++seed) {
      chunks_.push_back(
          MakeSyntheticChunk(spec, {.identity = {1, 1, 1}, .frames = kFrames, .end = kTerminated}, seed));
    }
  }
  // The chunk with this sequence, an episode of its own. Valid until the next call.
  std::span<std::byte> At(uint64_t sequence) {
    std::vector<std::byte>& chunk = chunks_[sequence % kDistinct];
    constexpr size_t kSequenceAt = 32;
    constexpr size_t kEpisodeAt = 40;
    std::memcpy(&chunk[kSequenceAt], &sequence, 8);
    std::memcpy(&chunk[kEpisodeAt], &sequence, 8);
    const uint64_t checksum = Xxh3(std::span(chunk).first(chunk.size() - 8));
    std::memcpy(&chunk[chunk.size() - 8], &checksum, 8);
    return chunk;
  }
  double mean_bytes() const {
    size_t bytes = 0;
    for (const auto& chunk : chunks_) bytes += chunk.size();
    return static_cast<double>(bytes) / kDistinct;
  }

 private:
  static constexpr uint64_t kDistinct = 32;
  std::vector<std::vector<std::byte>> chunks_;
};

}  // namespace dadrl::bench
