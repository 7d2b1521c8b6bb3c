// Stored experience for reading only: no lock, nothing is mended, a running replay is not disturbed.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "common/io/mapped_file.h"
#include "common/step/step_spec.h"
#include "common/util/result.h"
#include "proto/experience.h"

namespace dadrl {

// Bytes that are no whole chunk of this replay.
struct Damage {
  std::filesystem::path file;
  uint64_t offset = 0;
  uint64_t bytes = 0;
  std::string what;
};

// The segments of one or more shards, as long as they were when they were opened. Not thread safe.
class ShardReader {
 public:
  // `directory`: a shard's folder, a snapshot, or a folder of shards (`replay` of a run, or the run itself).
  // kNotFound: no segment anywhere; kCorrupt: no segment says what it holds, or they hold different things.
  // What is named like a segment and is none (a link, a FIFO, far too long) is damage, and never opened.
  static Result<ShardReader> Open(const std::filesystem::path& directory);

  // Visits every whole chunk, shard by shard in the order it was stored; `visit` returns false to stop.
  void ForEachChunk(const std::function<bool(const std::filesystem::path& file, uint64_t offset,
                                             const ChunkView& chunk)>& visit,
                    const std::function<void(const Damage&)>& on_damage) const;

  const StepSpec& spec() const { return spec_; }
  uint64_t schema() const { return schema_; }
  size_t segments() const { return segments_.size(); }
  uint64_t bytes() const;
  // Of one shard's segments.
  uint64_t BytesOf(const std::filesystem::path& shard) const;
  const std::vector<std::filesystem::path>& shards() const { return shards_; }

 private:
  struct SegmentFile {
    std::filesystem::path path;
    uint64_t id = 0;
    MappedFile file;
    bool newest = false;  // of its shard: it may be growing
  };
  ShardReader() = default;
  Status AddShard(const std::filesystem::path& directory);
  Status FindSchema();

  std::vector<std::filesystem::path> shards_;
  std::vector<SegmentFile> segments_;
  std::vector<Damage> refused_;  // files
  uint64_t schema_ = 0;
  StepSpec spec_;
};

}  // namespace dadrl
