// Where this installation keeps its programs and scenarios.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

// A program that stands beside this one ("dadrl-actor"). kNotFound with the remedy when it does not.
Result<std::filesystem::path> FindExecutable(std::string_view name);

// ../share/dadrl beside the folder of this program: what is installed with it.
std::filesystem::path SharedFolder();

// $DADRL_SCENARIOS, else ../share/dadrl/scenarios beside the folder of this program.
std::filesystem::path ScenarioFolder();

// Its scenarios, sorted; empty when there is no such folder.
std::vector<std::string> ScenarioNames();

// kInvalidArgument with all names and the nearest one when there is no such scenario ("all" is one);
// kNotFound when no scenario is installed at all.
Status CheckScenario(const std::string& name);

}  // namespace dadrl
