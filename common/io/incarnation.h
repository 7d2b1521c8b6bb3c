// Which start of a process this is.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace dadrl {

// Tells a process from the one of the same name before it: `wall_time_ns` (WallTimeNs), or one more than the
// last where the clock was set back, since peers ignore what seems to come from a dead predecessor. Kept in
// <run directory>/incarnations/NAME; when it cannot be kept, that is logged, and the clock alone counts the
// next time. Blocks on the disk.
uint64_t NextIncarnation(const std::filesystem::path& run_directory, const std::string& name,
                         int64_t wall_time_ns);

}  // namespace dadrl
