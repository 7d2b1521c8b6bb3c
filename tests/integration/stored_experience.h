// What a run stored, looked at when it has ended.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/step/driving_shape.h"
#include "tests/replay/service/stored_chunks.h"

namespace dadrl {

// Expects that each incarnation of each actor has its chunks 1, 2, 3, ... in shard 0, each once: nothing that
// was acknowledged is lost, nothing is stored twice. Nothing of it may have left the replay by its bounds.
inline void ExpectEveryChunkOnce(const std::filesystem::path& run) {
  Config config;
  ASSERT_TRUE(LoadYaml(run / "config.yaml", config));
  const auto chunks =
      ReadStoredChunks(run / "replay" / "shard-0", SchemaHash(DrivingShape::From(config.observation)));
  ASSERT_TRUE(chunks) << chunks.error().message;
  std::map<std::pair<uint32_t, uint64_t>, uint64_t> last;  // by actor and incarnation
  for (const auto& [identity, copies] : *chunks) {
    EXPECT_EQ(copies.size(), 1u);
    uint64_t& sequence = last[{identity.actor, identity.incarnation}];
    EXPECT_EQ(identity.sequence, sequence + 1) << "what lies between is lost";
    sequence = identity.sequence;
  }
  EXPECT_FALSE(last.empty());
}

}  // namespace dadrl
