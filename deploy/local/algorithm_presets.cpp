#include "deploy/local/algorithm_presets.h"

#include <algorithm>
#include <system_error>
#include <vector>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"
#include "common/util/shown.h"
#include "deploy/local/executables.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> PresetNames(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

}  // namespace

Result<Config> LoadPreset(const std::string& algorithm) {
  const fs::path folder = SharedFolder() / "algorithms";
  const std::vector<std::string> names = PresetNames(folder);
  if (names.empty()) {
    return Fail(ErrorCode::kNotFound, "no presets in {}: build everything (cmake --build --preset release)",
                folder.string());
  }
  if (std::ranges::find(names, algorithm) == names.end()) {
    return Fail(ErrorCode::kInvalidArgument,
                "algorithm.name: '{}' is unknown; the nearest is '{}' (there are: {})", Shown(algorithm),
                NearestName(algorithm, names), fmt::join(names, ", "));
  }
  Config config;
  config.algorithm.name = algorithm;
  DADRL_RETURN_IF_ERROR(LoadYaml(folder / (algorithm + ".yaml"), config));
  return config;
}

}  // namespace dadrl
