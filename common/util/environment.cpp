#include "common/util/environment.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>

namespace dadrl {
namespace {

constexpr std::array kVariables = {kScenariosVariable, kPoliciesVariable, kBeatsVariable, kIsaVariable};

}  // namespace

std::optional<std::string> FromEnvironment(std::string_view variable) {
  const char* const value = std::getenv(std::string(variable).c_str());
  if (value == nullptr || *value == '\0') return std::nullopt;
  return value;
}

std::string FolderRemedy(std::string_view variable, std::string_view otherwise) {
  if (!FromEnvironment(variable)) return std::string(otherwise);
  return fmt::format("{} names this folder: correct it, or unset it", variable);
}

std::vector<std::string> UnknownVariables(const char* const* environment) {
  std::vector<std::string> unknown;
  for (; *environment != nullptr; ++environment) {
    const std::string_view entry(*environment);
    const std::string_view name = entry.substr(0, entry.find('='));
    if (name.starts_with("DADRL_") && std::ranges::find(kVariables, name) == kVariables.end()) {
      unknown.emplace_back(name);
    }
  }
  return unknown;
}

}  // namespace dadrl
