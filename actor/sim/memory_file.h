// A file that lives in memory and has a path: for libraries that read their input from files.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "common/util/result.h"

namespace dadrl {

// Vanishes with the object or the process. Not thread safe.
class MemoryFile {
 public:
  // kExhausted: out of memory or descriptors.
  static Result<MemoryFile> Create(const char* name);
  ~MemoryFile();
  MemoryFile(MemoryFile&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}
  MemoryFile& operator=(MemoryFile&&) = delete;

  // Openable by this process.
  std::string path() const;
  Status Write(std::string_view text);  // replaces the contents
  std::string Read() const;

 private:
  explicit MemoryFile(int descriptor) : descriptor_(descriptor) {}
  int descriptor_;
};

}  // namespace dadrl
