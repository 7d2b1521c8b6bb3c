// What must hold of a replay whatever was done to it.
#pragma once

#include <filesystem>

#include "tests/replay/service/service_fixture.h"
#include "tests/replay/service/stored_chunks.h"

namespace dadrl {

class ReplayFault : public ReplayServiceTest {
 protected:
  ReplayFault() { config_.replay.max_disk_bytes = 1 << 28; }  // so that segments may be as small as tests ask

  std::filesystem::path Shard() const { return folder_.path() / "run" / "replay" / "shard-0"; }

  // Every chunk that `actor` was told is stored is there once, byte for byte; of the others, none twice.
  void ExpectStoredOnce(const StoredChunks& stored, const PeerActor& actor, uint64_t incarnation) {
    for (uint64_t sequence = 1; sequence <= actor.produced(); ++sequence) {
      const auto found = stored.find({actor.id(), incarnation, sequence});
      if (found == stored.end()) {
        EXPECT_GT(sequence, actor.stored()) << "acknowledged, and gone";
        continue;
      }
      ASSERT_EQ(found->second.size(), 1u) << "actor " << actor.id() << ", chunk " << sequence;
      EXPECT_EQ(found->second[0], actor.chunk(sequence));
    }
  }
};

}  // namespace dadrl
