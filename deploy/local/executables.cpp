#include "deploy/local/executables.h"

#include <algorithm>
#include <system_error>

#include "common/config/config_schema.h"
#include "common/util/environment.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

fs::path OwnFolder() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

}  // namespace

Result<fs::path> FindExecutable(std::string_view name) {
  fs::path path = OwnFolder() / name;
  std::error_code error;
  if (!fs::exists(path, error)) {
    return Fail(ErrorCode::kNotFound,
                "{} is missing beside dadrl: build everything (cmake --build --preset release)",
                path.string());
  }
  return path;
}

fs::path SharedFolder() { return OwnFolder().parent_path() / "share/dadrl"; }

fs::path ScenarioFolder() {
  if (const auto folder = FromEnvironment(kScenariosVariable)) return *folder;
  return SharedFolder() / "scenarios";
}

std::vector<std::string> ScenarioNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(ScenarioFolder(), error)) {
    if (fs::exists(entry.path() / "scenario.yaml", error)) names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

Status CheckScenario(const std::string& name) {
  const std::vector<std::string> names = ScenarioNames();
  if (names.empty()) {
    return Fail(ErrorCode::kNotFound, "no scenarios in {}: {}", ScenarioFolder().string(),
                FolderRemedy(kScenariosVariable, "build everything (cmake --build --preset release)"));
  }
  if (name == kAllScenarios || std::find(names.begin(), names.end(), name) != names.end()) return {};
  return Fail(ErrorCode::kInvalidArgument, "unknown scenario '{}'; the nearest is '{}' (there are: {})", name,
              NearestName(name, names), fmt::join(names, ", "));
}

}  // namespace dadrl
