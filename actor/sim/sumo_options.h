// Which of SUMO's options a scenario may set.
#pragma once

#include <filesystem>
#include <string>

#include "common/util/result.h"

namespace dadrl {

constexpr const char* kRouteFiles = "route-files";
constexpr const char* kAdditionalFiles = "additional-files";

// SUMO's name of the option `name` of a scenario's `sumo:` section, dashes before it left out ("routes" and
// "r" are "route-files"). kInvalidArgument: it is no name, the program owns it, however it is spelled (step
// length, seed, begin and end, network, configuration, state, remote control, what is printed), with what to
// write instead; or SUMO would write a file. Whether there is such an option, SUMO knows.
Result<std::string> ScenarioOption(std::string name);

// The comma separated files of `value` by absolute path; a relative one is looked for in `folder`, then in
// the working directory. kInvalidArgument: one is not there.
Result<std::string> FilesFrom(const std::filesystem::path& folder, const std::string& value);

}  // namespace dadrl
