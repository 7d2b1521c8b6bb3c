// Whole files into memory, with a bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// kNotFound when there is no such file, kExhausted when it is longer than `max_bytes` (nothing is allocated
// then), kInvalidArgument when it is no regular file, or a link that is not to be followed. Blocks on the
// disk.
Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& path, uint64_t max_bytes,
                                        Links links = Links::kRefuse);
Result<std::string> ReadTextFile(const std::filesystem::path& path, uint64_t max_bytes,
                                 Links links = Links::kRefuse);

// The two parts of it, for those who read a piece at a time.
struct BoundedFile {
  FileDescriptor descriptor;
  uint64_t bytes = 0;  // its length
};
Result<BoundedFile> OpenBounded(const std::filesystem::path& path, uint64_t max_bytes, Links links);
// Fills `bytes` from the descriptor's position, through short reads and interruptions; how many there were,
// fewer only at the end of the file.
Result<size_t> ReadUpTo(const FileDescriptor& file, std::span<std::byte> bytes,
                        const std::filesystem::path& path);

}  // namespace dadrl
