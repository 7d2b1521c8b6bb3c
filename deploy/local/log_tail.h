// The end of a log file, for a message about the process that wrote it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"

namespace dadrl {

// The last `lines` lines, at most 16 KiB of them; empty when the file cannot be read, or is none of ours.
std::vector<std::string> LogTail(const std::filesystem::path& file, size_t lines);
std::vector<std::string> LogTail(const FileDescriptor& file, size_t lines);

}  // namespace dadrl
