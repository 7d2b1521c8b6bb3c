// TensorBoard event files, written without TensorBoard: scalars and the starts of sessions.
//
// A file is a sequence of TFRecords (u64 length, masked crc32c of it, data, masked crc32c of the data), each
// an Event message in protobuf encoding (tensorflow/core/util/event.proto).
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string_view>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

struct TaggedScalar {
  std::string_view tag;  // "loss/critic": what stands before the slash groups the charts
  double value = 0.0;
};

// Not thread safe; each call writes through to the system, so that a killed process loses nothing.
class TensorBoardWriter {
 public:
  // A new event file in `directory` (created when missing): TensorBoard joins the files of a folder, in the
  // order of their names, into one run, so a resumed training continues the curves. The file begins with a
  // SessionLog.START at `first_step`: TensorBoard drops what earlier sessions wrote for that step and later
  // ones (`_Purge` in its event accumulator), steps that a killed learner had done after its last checkpoint.
  static Result<TensorBoardWriter> Create(const std::filesystem::path& directory, int64_t first_step);

  // One event of all `scalars` at `step`. Values that are not finite are left out.
  Status Add(int64_t step, double wall_time_s, std::span<const TaggedScalar> scalars);

  const std::filesystem::path& path() const { return path_; }

 private:
  TensorBoardWriter(std::filesystem::path path, FileDescriptor file)
      : path_(std::move(path)), file_(std::move(file)) {}
  Status Begin(double wall_time_s, int64_t first_step);
  Status WriteRecord(std::span<const std::byte> event);

  std::filesystem::path path_;
  FileDescriptor file_;
};

}  // namespace dadrl
