// Whole files into memory, with a bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
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

}  // namespace dadrl
