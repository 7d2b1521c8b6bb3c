// logs/episodes-actor-N.csv: every episode this actor finished, with all its metrics. Telemetry is lossy;
// this is not. (The run's episodes.csv is the launcher's view of all actors, from telemetry.)
#pragma once

#include <filesystem>

#include "actor/collect/collector.h"
#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe. A row is one write; half a row that a killed actor left is cut off at the next start.
class ActorEpisodeLog {
 public:
  // Creates the folder and the file, or goes on behind its last whole row.
  static Result<ActorEpisodeLog> Open(const std::filesystem::path& path);
  Status Append(uint64_t incarnation, int64_t wall_time_ns, const CollectedEpisode& episode);

 private:
  ActorEpisodeLog(std::filesystem::path path, FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  FileDescriptor file_;
};

}  // namespace dadrl
