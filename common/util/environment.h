// The environment variables that dadrl reads, so that one with a slip in its name or value is not passed
// over.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dadrl {

// All of them.
constexpr std::string_view kScenariosVariable = "DADRL_SCENARIOS";  // folder of scenarios
constexpr std::string_view kPoliciesVariable = "DADRL_POLICIES";    // folder of shipped policies
constexpr std::string_view kBeatsVariable = "DADRL_BEATS";          // set by a supervisor for its children
constexpr std::string_view kIsaVariable = "DADRL_ISA";              // of the kernels (isa.h)

// Its value; nothing when it is not set, or empty.
std::optional<std::string> FromEnvironment(std::string_view variable);

// What to do about a folder without what it should hold: where `variable` named it, that it did.
std::string FolderRemedy(std::string_view variable, std::string_view otherwise);

// Of `environment` ("NAME=value", null at the end) the names that begin with DADRL_ and that nobody reads.
std::vector<std::string> UnknownVariables(const char* const* environment);

}  // namespace dadrl
