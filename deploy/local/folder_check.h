// What a folder's file system can do that a run makes use of.
#pragma once

#include <filesystem>

#include "deploy/local/machine_checks.h"

namespace dadrl {

// Tries symbolic links, hard links and locks in a folder of its own under `folder`, and removes that again.
// What is not there has a way round, which the detail names, but for locks.
MachineCheck CheckFolder(const std::filesystem::path& folder);

}  // namespace dadrl
