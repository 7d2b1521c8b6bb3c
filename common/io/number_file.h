// A number that must survive the process that wrote it, also where a disk is full.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/util/result.h"

namespace dadrl {

// kNotFound when there is no such file, kCorrupt when it holds no number. Blocks on the disk.
Result<uint64_t> ReadNumber(const std::filesystem::path& path);

// Atomic and durable. Where there is no room for a new file, the old one is overwritten in place, which needs
// none: its number always takes the same bytes, within one sector. Blocks on the disk.
Status WriteNumber(const std::filesystem::path& path, uint64_t number);

}  // namespace dadrl
