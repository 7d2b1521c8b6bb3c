// A whole file as memory, for reading: only what is touched is resident.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "common/io/file_descriptor.h"
#include "common/io/guarded_mapping.h"
#include "common/util/result.h"

namespace dadrl {

// The file as long as it is when it is opened. What is cut off or cannot be read afterwards is zeros
// (guarded_mapping.h). Movable; thread safe.
class MappedFile {
 public:
  // kNotFound when there is no such file, kInvalidArgument when it is no regular one, or a link that is not
  // to be followed. An empty file has no bytes.
  static Result<MappedFile> Open(const std::filesystem::path& path, Links links = Links::kRefuse);

  std::span<const std::byte> bytes() const { return mapping_.bytes(); }
  bool damaged() const { return mapping_.damaged(); }

 private:
  explicit MappedFile(GuardedMapping mapping) : mapping_(std::move(mapping)) {}
  GuardedMapping mapping_;
};

}  // namespace dadrl
