// episodes.csv: every training episode that telemetry told of, a row each.
#pragma once

#include <filesystem>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"
#include "proto/telemetry.h"

namespace dadrl {

// Not thread safe. A row is there whole or not at all: half of one that a full disk or a killed launcher left
// is cut off.
class EpisodeLog {
 public:
  static Result<EpisodeLog> Open(const std::filesystem::path& path);
  Status Append(const EpisodeReport& report);

 private:
  EpisodeLog(std::filesystem::path path, FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}

  std::filesystem::path path_;
  FileDescriptor file_;
};

}  // namespace dadrl
