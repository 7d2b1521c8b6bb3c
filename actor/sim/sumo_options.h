// Which of SUMO's options a scenario may set.
#pragma once

#include <filesystem>
#include <string>

#include "common/util/result.h"

namespace dadrl {

constexpr const char* kRouteFiles = "route-files";
constexpr const char* kAdditionalFiles = "additional-files";

// SUMO's long name of the option `name` of a scenario's `sumo:` section ("routes" and "r" are "route-files").
// kInvalidArgument: the program owns it (step length, seed, begin and end, network, configuration, state,
// remote control), with what to write instead; or SUMO would write a file.
Result<std::string> ScenarioOption(const std::string& name);

// The comma separated files of `value` by absolute path; a relative one is looked for in `folder`, then in
// the working directory. kInvalidArgument: one is not there.
Result<std::string> FilesFrom(const std::filesystem::path& folder, const std::string& value);

}  // namespace dadrl
