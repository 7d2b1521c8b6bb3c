// episodes.csv: every training episode of this machine's actors over all sessions of the run, a row each.
//
// The rows come from the actors' own logs (logs/episodes-actor-N.csv), which no network can lose, repeat or
// forge. Episodes of a machine that joined are in its own run directory.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <utility>

#include "common/io/row_file.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe.
class EpisodeLog {
 public:
  // Goes on with the table at `path`, or starts it. What is in the actors' logs, in the folder `logs`, and
  // not in the table (the launcher was killed) follows with the first Update.
  static Result<EpisodeLog> Open(const std::filesystem::path& path, const std::filesystem::path& logs);

  // Appends the rows that the actors' logs gained, in the order of their times. After an error (a full disk)
  // the next call takes the same rows again. Blocks on the disk.
  Status Update();

  // Rows of the table, and the simulation steps in them.
  uint64_t episodes() const { return episodes_; }
  uint64_t env_steps() const { return env_steps_; }

 private:
  struct Actor {
    uint64_t read = 0;          // bytes of its log that are in the table
    uint64_t known_end = 0;     // its log when the table was opened: rows up to there may be in the table,
    uint64_t last_episode = 0;  // and those up to this episode are
  };
  struct NewRows;

  EpisodeLog(RowFile table, std::filesystem::path logs) : table_(std::move(table)), logs_(std::move(logs)) {}
  void CountTable(const std::filesystem::path& path);
  // Calls `visit(actor, path)` for each actor's log there is.
  template <typename Visit>
  void ForEachLog(Visit visit) const;

  RowFile table_;
  std::filesystem::path logs_;
  uint64_t episodes_ = 0;
  uint64_t env_steps_ = 0;
  std::map<int, Actor> actors_;
};

}  // namespace dadrl
