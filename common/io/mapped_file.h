// A whole file as memory, for reading: only what is touched is resident.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// The file as long as it is when it is opened; it must not be cut shorter meanwhile. Movable; thread safe.
class MappedFile {
 public:
  // kNotFound when there is no such file, kInvalidArgument when it is no regular one, or a link that is not
  // to be followed. An empty file has no bytes.
  static Result<MappedFile> Open(const std::filesystem::path& path, Links links = Links::kRefuse);
  ~MappedFile();
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;

  std::span<const std::byte> bytes() const { return bytes_; }

 private:
  explicit MappedFile(std::span<const std::byte> bytes) : bytes_(bytes) {}
  std::span<const std::byte> bytes_;
};

}  // namespace dadrl
