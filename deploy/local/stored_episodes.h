// What a run's replay holds, counted by the program that stores it.
#pragma once

#include <poll.h>

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "common/util/clock.h"
#include "common/util/result.h"
#include "deploy/local/captured_process.h"

namespace dadrl {

struct StoredEpisodes {
  uint64_t frames = 0;    // with a decision
  uint64_t episodes = 0;  // whole ones
  uint64_t successes = 0;
};

// Counts again and again, in a process of its own that reads the files: a running replay is not disturbed.
// Not thread safe; thread rule as ChildProcess.
class StoredEpisodeCounter {
 public:
  explicit StoredEpisodeCounter(std::filesystem::path replay) : replay_(std::move(replay)) {}

  // Begins to count unless that is under way.
  Status Begin();
  bool counting() const { return process_.has_value(); }
  void AppendWaitFds(std::vector<pollfd>& fds) const;
  std::vector<pid_t> RunningPids() const;
  // What was counted, once it is; nothing while that goes on. kInternal: the folder cannot be read.
  std::optional<Result<StoredEpisodes>> Step();

 private:
  const std::filesystem::path replay_;
  std::optional<CapturedProcess> process_;
};

}  // namespace dadrl
