#include "replay/service/chunk_verifier.h"

#include <algorithm>

namespace dadrl {

Status ChunkVerifier::Check(const ChunkView& chunk) {
  const ChunkIdentity& identity = chunk.header().identity;
  Trust& trust = trust_[identity.actor];
  if (trust.incarnation != identity.incarnation) trust = {.incarnation = identity.incarnation};
  if (!all_ && trust.sound_chunks >= kProbation) {
    Status sound = CheckFrame(chunk, static_cast<int>(random_.Below(static_cast<uint64_t>(chunk.frames()))));
    if (!sound) trust.sound_chunks = 0;
    return sound;
  }
  for (int frame = 0; frame < chunk.frames(); ++frame) {
    if (Status sound = CheckFrame(chunk, frame); !sound) {
      trust.sound_chunks = 0;
      return sound;
    }
  }
  trust.sound_chunks = std::min(trust.sound_chunks + 1, kProbation);
  return {};
}

Status ChunkVerifier::CheckFrame(const ChunkView& chunk, int frame) {
  const Status decoded = codec_.Decode(chunk.payload(frame), row_);
  if (decoded) return {};
  return Fail(ErrorCode::kCorrupt, "actor {}, episode {}, frame {}: {}", chunk.header().identity.actor,
              chunk.header().episode, chunk.header().first_frame + static_cast<uint32_t>(frame),
              decoded.error().message);
}

}  // namespace dadrl
