// Which actor this is, over its restarts.
#pragma once

#include <filesystem>
#include <string>

#include "proto/lease.h"

namespace dadrl {

// The token of the actor `name` of this run directory: drawn at random by its first process, and kept in
// <run directory>/incarnations/NAME.token, so that the run knows an actor that was started again. When it
// cannot be kept, that is logged, and the next process is a stranger to the run until this one's lease has
// ended. Blocks on the disk.
LeaseToken KeptToken(const std::filesystem::path& run_directory, const std::string& name);

}  // namespace dadrl
