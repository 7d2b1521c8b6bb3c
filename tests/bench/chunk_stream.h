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

  // Of the default observation. The first one of a process draws the payloads, which takes a second: a
  // benchmark that forks its peers makes one before, and they have them for nothing.
  ChunkStream() : chunks_(Payloads()) {}

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

 private:
  static constexpr uint64_t kDistinct = 32;

  static const std::vector<std::vector<std::byte>>& Payloads() {
    static const std::vector<std::vector<std::byte>> payloads = [] {
      std::vector<std::vector<std::byte>> chunks;
      const SyntheticChunk chunk{.identity = {1, 1, 1}, .frames = kFrames, .end = kTerminated};
      for (uint64_t seed = 0; seed < kDistinct; ++seed) {
        chunks.push_back(MakeSyntheticChunk(DrivingShape{}, chunk, seed));
      }
      return chunks;
    }();
    return payloads;
  }

  std::vector<std::vector<std::byte>> chunks_;
};

}  // namespace dadrl::bench
