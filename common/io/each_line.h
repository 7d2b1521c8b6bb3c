// The lines of a file that may be longer than memory.
#pragma once

#include <filesystem>
#include <functional>
#include <string_view>

namespace dadrl {

constexpr size_t kLongestLine = size_t{1} << 20;

// Calls `visit` with each line of a regular file, without its line break; the last need not have one. Nothing
// for a file that is missing, a link or no regular file, and nothing from the first line on that is longer
// than kLongestLine, or that cannot be read. Blocks on the disk.
void ForEachLine(const std::filesystem::path& path, const std::function<void(std::string_view line)>& visit);

}  // namespace dadrl
