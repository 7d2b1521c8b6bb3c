// Which weight versions may have been broadcast, on disk: a learner that was killed after its last checkpoint
// must not give a used number to other weights.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/util/result.h"

namespace dadrl {

// A file or a checkpoint that claims more is damaged: numbers must not run out and begin anew.
constexpr uint32_t kMaxWeightsVersion = uint32_t{1} << 31;

// Reserves versions in small blocks, so that a file is written once in many broadcasts. Not thread safe.
class VersionReserve {
 public:
  // Reads checkpoints/weights_version of a run; a folder without one starts at 0. kCorrupt when the file is
  // not a number.
  static Result<VersionReserve> Open(const std::filesystem::path& directory);

  // Every version up to this one may be in use.
  uint32_t highest() const { return highest_; }

  // To be called before `version` leaves the process; on an error it must not. Blocks on the disk when a new
  // block is needed; a full disk is no obstacle once the file is there (common/io/number_file.h).
  Status Use(uint32_t version);

 private:
  VersionReserve(std::filesystem::path path, uint32_t highest) : path_(std::move(path)), highest_(highest) {}

  std::filesystem::path path_;
  uint32_t highest_;
};

}  // namespace dadrl
