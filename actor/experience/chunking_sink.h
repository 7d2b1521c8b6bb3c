// Frames become chunks: the one place where episodes are cut.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "actor/experience/experience_sink.h"
#include "common/config/config.h"
#include "proto/experience.h"

namespace dadrl {

// Cuts episodes into chunks of actor.chunk_frames, or fewer where they would exceed kMaxChunkBytes, and
// numbers them 1, 2, 3, ... Not thread safe.
class ChunkingSink : public ExperienceSink {
 public:
  ChunkingSink(const Config& config, uint32_t actor, uint64_t incarnation);

  void BeginEpisode(uint64_t episode) override;
  void AddTransition(const Observation& observation, std::span<const float> decision, float reward,
                     uint8_t flags, uint32_t policy_version) override;
  void AddFinal(const Observation& observation) override;
  void EndEpisode() override;

 protected:
  virtual void OnChunk(uint64_t sequence, std::vector<std::byte> bytes) = 0;
  // Of the last chunk; 0 before the first.
  uint64_t last_sequence() const { return identity_.sequence; }

 private:
  // After each frame.
  void CutWhenFull();
  void Cut();

  const int chunk_frames_;
  ChunkIdentity identity_;
  ChunkBuilder builder_;
  uint64_t episode_ = 0;
  uint32_t next_frame_ = 0;
};

}  // namespace dadrl
