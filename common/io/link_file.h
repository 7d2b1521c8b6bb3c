// Names that point to the newest of something ("latest", "best"), also on file systems without symbolic
// links.
#pragma once

#include <filesystem>

#include "common/util/result.h"

namespace dadrl {

// Makes `link` point to `target`, a name in the same folder, replacing an earlier link at once: a symbolic
// link or, where the file system has none (said once), a small file that holds the name. kInvalidArgument
// when something else has that name: it is left alone.
Status LinkAtomically(const std::filesystem::path& link, const std::filesystem::path& target);

// `path` with each part that is such a small file replaced by what it names; symbolic links are left to the
// system. What is no link, or is not there, stays as it is. Whatever takes a path from a user calls this.
std::filesystem::path FollowLinks(const std::filesystem::path& path);

}  // namespace dadrl
