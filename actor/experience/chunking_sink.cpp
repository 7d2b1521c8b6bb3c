#include "actor/experience/chunking_sink.h"

#include <algorithm>

#include "common/step/step_spec_of.h"

namespace dadrl {

ChunkingSink::ChunkingSink(const Config& config, uint32_t actor, uint64_t incarnation)
    : chunk_frames_(std::clamp(config.actor.chunk_frames, 1, kMaxChunkFrames)),
      identity_{.actor = actor, .incarnation = incarnation},
      builder_(StepSpecOf(config), config.actor.floats) {}

void ChunkingSink::BeginEpisode(uint64_t episode) {
  EndEpisode();
  episode_ = episode;
  next_frame_ = 0;
  builder_.Begin(episode_, next_frame_);
}

void ChunkingSink::AddTransition(const Observation& observation, std::span<const float> decision,
                                 float reward, uint8_t flags, uint32_t policy_version) {
  builder_.AddTransition(observation, decision, reward, flags, policy_version);
  CutWhenFull();
}

void ChunkingSink::AddFinal(const Observation& observation) {
  builder_.AddFinal(observation);
  CutWhenFull();
}

void ChunkingSink::EndEpisode() {
  if (builder_.frames() > 0) Cut();
}

void ChunkingSink::CutWhenFull() {
  ++next_frame_;
  if (builder_.frames() >= chunk_frames_ || builder_.full()) Cut();
}

void ChunkingSink::Cut() {
  ++identity_.sequence;
  std::vector<std::byte> bytes = builder_.Finish(identity_);
  builder_.Begin(episode_, next_frame_);
  OnChunk(identity_.sequence, std::move(bytes));
}

}  // namespace dadrl
