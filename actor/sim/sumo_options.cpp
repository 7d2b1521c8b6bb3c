#include "actor/sim/sumo_options.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/util/shown.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

struct OwnedOption {
  std::string_view name;
  std::string_view remedy;
};

constexpr std::string_view kStepRemedy =
    "a step is 0.1 s here; driver.actionStepLength makes drivers think less often";
constexpr std::string_view kSeedRemedy = "the episode's seed decides";
constexpr std::string_view kTimeRemedy =
    "an episode begins at 0 and ends with the ego; warm_up_s lets traffic form";
constexpr std::string_view kNetworkRemedy =
    "the network is the scenario's network.net.xml, or that of 'network'";
constexpr std::string_view kConfigurationRemedy = "write its options here one by one";
constexpr std::string_view kStateRemedy = "each episode starts anew";
constexpr std::string_view kRemoteRemedy = "SUMO runs inside the program";
constexpr std::string_view kPrintRemedy =
    "standard output is the program's own; run `sumo` itself for what it prints";

// With their short and old names (SUMO 1.15, MSFrame and SystemFrame).
constexpr std::array<OwnedOption, 41> kOwned{{{"step-length", kStepRemedy},
                                              {"seed", kSeedRemedy},
                                              {"srand", kSeedRemedy},
                                              {"random", kSeedRemedy},
                                              {"abs-rand", kSeedRemedy},
                                              {"begin", kTimeRemedy},
                                              {"b", kTimeRemedy},
                                              {"end", kTimeRemedy},
                                              {"e", kTimeRemedy},
                                              {"net-file", kNetworkRemedy},
                                              {"net", kNetworkRemedy},
                                              {"n", kNetworkRemedy},
                                              {"configuration-file", kConfigurationRemedy},
                                              {"configuration", kConfigurationRemedy},
                                              {"c", kConfigurationRemedy},
                                              {"save-configuration", kConfigurationRemedy},
                                              {"save-config", kConfigurationRemedy},
                                              {"C", kConfigurationRemedy},
                                              {"save-template", kConfigurationRemedy},
                                              {"save-schema", kConfigurationRemedy},
                                              {"load-state", kStateRemedy},
                                              {"load-state.offset", kStateRemedy},
                                              {"load-state.remove-vehicles", kStateRemedy},
                                              {"remote-port", kRemoteRemedy},
                                              {"num-clients", kRemoteRemedy},
                                              {"gui-settings-file", kRemoteRemedy},
                                              {"g", kRemoteRemedy},
                                              {"help", kPrintRemedy},
                                              {"?", kPrintRemedy},
                                              {"version", kPrintRemedy},
                                              {"V", kPrintRemedy},
                                              {"print-options", kPrintRemedy},
                                              {"verbose", kPrintRemedy},
                                              {"v", kPrintRemedy},
                                              {"no-step-log", kPrintRemedy},
                                              {"step-log.period", kPrintRemedy},
                                              {"duration-log.statistics", kPrintRemedy},
                                              {"t", kPrintRemedy},
                                              {"save-configuration.relative", kConfigurationRemedy},
                                              {"save-commented", kConfigurationRemedy},
                                              {"save-template.commented", kConfigurationRemedy}}};

// What SUMO 1.15 would write, wherever a scenario that somebody else made says.
bool WritesAFile(std::string_view name) {
  constexpr std::array<std::string_view, 11> kWriting = {
      "log",       "l",        "message-log", "error-log",     "summary",      "tripinfo",
      "vehroutes", "netstate", "ndump",       "netstate-dump", "output-prefix"};
  return name.ends_with("output") || name.ends_with(".file") || name.starts_with("save-") ||
         std::ranges::find(kWriting, name) != kWriting.end();
}

}  // namespace

Result<std::string> ScenarioOption(std::string name) {
  // As one types it in a shell.
  name.erase(0, std::min(name.find_first_not_of('-'), name.size()));
  // "seed=1" would be two words to SUMO.
  const bool is_name = !name.empty() && std::ranges::all_of(name, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '-' || c == '.' || c == '_' || c == '?';
  });
  if (!is_name) {
    return Fail(ErrorCode::kInvalidArgument, "'{}' is not the name of an option of SUMO; write 'name: value'",
                Shown(name));
  }
  if (name == "routes" || name == "r") return std::string(kRouteFiles);
  if (name == "additional" || name == "a") return std::string(kAdditionalFiles);
  const auto owned = std::ranges::find(kOwned, std::string_view(name), &OwnedOption::name);
  if (owned == kOwned.end() && WritesAFile(name)) {
    return Fail(ErrorCode::kInvalidArgument,
                "SUMO's option '{}' is not for scenarios: every episode of every actor would write the same "
                "file; remove it, and run `sumo` itself for its outputs",
                Shown(name));
  }
  if (owned == kOwned.end()) return name;
  return Fail(ErrorCode::kInvalidArgument, "SUMO's option '{}' is not for scenarios: {}", Shown(name),
              owned->remedy);
}

Result<std::string> FilesFrom(const fs::path& folder, const std::string& value) {
  std::vector<std::string> files;
  std::istringstream list(value);
  for (std::string name; std::getline(list, name, ',');) {
    name.erase(0, name.find_first_not_of(" \t"));
    name.erase(name.find_last_not_of(" \t") + 1);
    if (name.empty()) continue;
    std::error_code error;
    fs::path file = folder / name;  // `name` alone where it is absolute
    if (!fs::is_regular_file(file, error)) file = fs::absolute(name, error);
    if (!fs::is_regular_file(file, error)) {
      return Fail(ErrorCode::kInvalidArgument,
                  "file '{}' is neither in the folder of scenario.yaml ({}) nor in the working directory",
                  Shown(name, 200), folder.string());
    }
    files.push_back(file.string());
  }
  return fmt::format("{}", fmt::join(files, ","));
}

}  // namespace dadrl
