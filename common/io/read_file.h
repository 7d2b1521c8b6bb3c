// Whole files into memory, with a bound.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// kNotFound when there is no such file, kExhausted when it is longer than `max_bytes` (nothing is allocated
// then). Blocks on the disk.
Result<std::vector<std::byte>> ReadFile(const std::filesystem::path& path, uint64_t max_bytes);
Result<std::string> ReadTextFile(const std::filesystem::path& path, uint64_t max_bytes);

}  // namespace dadrl
