// What the files of a shard hold, read as a restart would.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "proto/experience.h"
#include "replay/storage/segment_log.h"

namespace dadrl {

using StoredChunks = std::map<ChunkIdentity, std::vector<std::vector<std::byte>>>;

// Every whole chunk in `directory` by its identity: more than one under it is a duplicate. No replay may be
// running there.
inline Result<StoredChunks> ReadStoredChunks(const std::filesystem::path& directory, uint64_t schema) {
  StoredChunks chunks;
  SegmentLog::Recovery recovery;
  const auto visit = [&](const std::shared_ptr<const Segment>&, std::span<const std::byte> record) {
    const auto chunk = ChunkView::Parse(record);
    if (!chunk) return false;
    chunks[chunk->header().identity].emplace_back(record.begin(), record.end());
    return true;
  };
  DADRL_ASSIGN_OR_RETURN(const auto log, SegmentLog::Open({directory, schema}, visit, recovery));
  return chunks;
}

}  // namespace dadrl
