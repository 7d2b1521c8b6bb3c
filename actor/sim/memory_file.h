// A file that lives in memory and has a path: for libraries that read their input from files.
#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Vanishes with the object or the process. Not thread safe.
class MemoryFile {
 public:
  // kExhausted: out of memory or descriptors.
  static Result<MemoryFile> Create(const char* name);

  // Openable by this process.
  std::string path() const;
  Status Write(std::string_view text);  // replaces the contents
  std::string Read() const;

 private:
  explicit MemoryFile(FileDescriptor file) : file_(std::move(file)) {}
  FileDescriptor file_;
};

}  // namespace dadrl
