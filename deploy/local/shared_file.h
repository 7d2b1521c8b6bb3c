// Bytes as a file that child processes can open while this object lives: in memory, whatever the disk is
// like.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

class SharedFile {
 public:
  // `name` is for people who look at /proc. kExhausted without memory or descriptors.
  static Result<SharedFile> Create(const char* name, std::span<const std::byte> content);
  std::filesystem::path path() const;

 private:
  explicit SharedFile(FileDescriptor file) : file_(std::move(file)) {}
  FileDescriptor file_;
};

}  // namespace dadrl
