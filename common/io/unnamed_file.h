// A file in memory that no folder holds: it vanishes with its last descriptor.
#pragma once

#include <filesystem>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Empty, for reading and writing. `name` is for people who look into /proc. Where the system refuses files in
// memory (memfd_create), it lies in /dev/shm or the folder for temporary files, already removed. kExhausted:
// no memory or no descriptor left.
Result<FileDescriptor> OpenUnnamedFile(const char* name);

// Under which this process can open it once more, while `file` lives.
std::filesystem::path UnnamedFilePath(const FileDescriptor& file);

}  // namespace dadrl
