// System errors of file operations as errors that name the file and the remedy.
#pragma once

#include <filesystem>
#include <string_view>

#include "common/util/result.h"

namespace dadrl {

// `operation` is what was tried ("write", "open"), `error_number` the errno it left. Disk, quota or memory
// full, too many open files and files beyond the process's limit are kExhausted, a missing file or folder
// kNotFound, an error of the device kCorrupt, the rest kInternal.
Error IoError(std::string_view operation, const std::filesystem::path& path, int error_number);

}  // namespace dadrl
