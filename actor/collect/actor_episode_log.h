// logs/episodes-actor-N.csv: every episode this actor finished, with all its metrics. The launcher makes the
// run's episodes.csv of these tables.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "actor/collect/collector.h"
#include "common/io/row_file.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe. A row is there whole or not at all; half a row that a killed actor left is cut off at the
// next start.
class ActorEpisodeLog {
 public:
  // Creates the folder and the file, or goes on behind its last whole row. Where that is not possible now,
  // each Append tries again.
  static ActorEpisodeLog Open(const std::filesystem::path& path);

  // The largest number of an episode that was there; 0: none. The next one has the next number.
  uint64_t last_episode() const { return last_episode_; }

  // After an error (a full disk) the row is kept, up to a mebibyte of them, and written with the next one.
  Status Append(uint64_t incarnation, int64_t wall_time_ns, const CollectedEpisode& episode);

 private:
  ActorEpisodeLog(std::filesystem::path path, uint64_t last_episode)
      : path_(std::move(path)), last_episode_(last_episode) {}
  Status OpenTable();

  std::filesystem::path path_;
  std::optional<RowFile> table_;  // empty while it cannot be opened
  uint64_t last_episode_;
  std::string waiting_;  // rows that could not be written
};

}  // namespace dadrl
