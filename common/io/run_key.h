// The secret of a run: 128 random bits in its folder, for its owner alone. Who has it may take part.
#pragma once

#include <filesystem>
#include <string>

#include "common/util/result.h"

namespace dadrl {

// Where a run keeps it.
std::filesystem::path RunKeyFile(const std::filesystem::path& run_directory);

// The run's key, drawn and saved (mode 0600) when it has none yet. For the one process that holds the run's
// lock. Blocks on the disk.
Result<std::string> EnsureRunKey(const std::filesystem::path& run_directory);

// Saves `key` for a run that goes on elsewhere.
Status SaveRunKey(const std::filesystem::path& run_directory, const std::string& key);

// kNotFound when there is none, kCorrupt when the file holds something else. Follows no link.
Result<std::string> ReadRunKey(const std::filesystem::path& file);

}  // namespace dadrl
