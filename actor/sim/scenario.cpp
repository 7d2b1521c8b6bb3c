#include "actor/sim/scenario.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <system_error>

#include "actor/sim/sumo_options.h"
#include "common/config/config_schema.h"
#include "common/config/yaml_document.h"
#include "common/util/environment.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScenarioFile = "scenario.yaml";
constexpr const char* kNetworkFile = "network.net.xml";

// A fault of the file: where, and what is expected there. Becomes a value in LoadScenario.
class BadScenario : public std::runtime_error {
 public:
  BadScenario(int line, std::string_view what) : std::runtime_error(fmt::format("{}: {}", line, what)) {}
};

// The value as a number; nothing when it is none.
std::optional<double> AsNumber(const YamlNode& node) {
  double number = 0.0;
  const char* const end = node.text.data() + node.text.size();
  const auto [at, error] = std::from_chars(node.text.data(), end, number);
  if (!node.IsScalar() || error != std::errc() || at != end || !std::isfinite(number)) return std::nullopt;
  return number;
}

// A map of the file with its dotted name; refuses keys that are not in `known`. Borrows the node.
class Section {
 public:
  Section(const YamlNode& node, std::string name, const std::vector<std::string>& known)
      : node_(node), name_(std::move(name)) {
    if (!node_.IsMap()) {
      throw BadScenario(node_.line, fmt::format("'{}' must hold 'key: value' lines", name_));
    }
    for (const YamlEntry& entry : node_.entries) {
      if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
      throw BadScenario(entry.line, fmt::format("unknown key '{}'; the nearest is '{}'",
                                                Name(Shown(entry.key)), Name(NearestName(entry.key, known))));
    }
  }

  bool Has(const std::string& key) const { return node_.Find(key) != nullptr; }

  const YamlNode& Get(const std::string& key) const {
    if (const YamlNode* node = node_.Find(key)) return *node;
    throw BadScenario(node_.line, fmt::format("'{}' is missing", Name(key)));
  }

  double Number(const std::string& key, double min, double max) const {
    const YamlNode& value = Get(key);
    const auto number = AsNumber(value);
    if (!number || *number < min || *number > max) {
      throw BadScenario(value.line, fmt::format("'{}': '{}' is not a number between {:g} and {:g}", Name(key),
                                                Shown(value.text), min, max));
    }
    return *number;
  }

  int Whole(const std::string& key, int min, int max) const {
    const double number = Number(key, min, max);
    if (number != static_cast<int>(number)) {
      throw BadScenario(Get(key).line, fmt::format("'{}' is not a whole number", Name(key)));
    }
    return number;
  }

  std::vector<std::string> Names(const std::string& key) const {
    const YamlNode& list = Get(key);
    std::vector<std::string> names;
    for (const YamlNode& item : list.items) names.push_back(item.text);  // none of what is not a scalar
    if (names.empty() || std::ranges::any_of(names, &std::string::empty)) {
      throw BadScenario(list.line, fmt::format("'{}' must be a list of names", Name(key)));
    }
    return names;
  }

  // Any keys with single values, as text.
  std::vector<std::pair<std::string, std::string>> Pairs(const std::string& key) const {
    std::vector<std::pair<std::string, std::string>> pairs;
    if (!Has(key)) return pairs;
    const YamlNode& map = Get(key);
    for (const YamlEntry& entry : map.entries) {
      if (!entry.value.IsScalar()) break;
      pairs.emplace_back(entry.key, entry.value.text);
    }
    if (!map.IsMap() || pairs.size() != map.entries.size()) {
      throw BadScenario(map.line, fmt::format("'{}' must hold 'name: value' pairs", Name(key)));
    }
    return pairs;
  }

  FlowPosition Position(const std::string& key) const {
    if (!Has(key)) return FlowPosition::kRandom;
    const std::string& text = Get(key).text;
    if (text == "random") return FlowPosition::kRandom;
    if (text == "lane_end") return FlowPosition::kLaneEnd;
    throw BadScenario(Get(key).line, fmt::format("'{}' is not one of: random, lane_end", Name(key)));
  }

  std::string Name(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }

 private:
  const YamlNode& node_;
  std::string name_;
};

TrafficFlow ReadFlow(const YamlNode& node, size_t index) {
  const Section section(node, fmt::format("traffic.flows[{}]", index),
                        {"edges", "depart_lane", "arrival_lane", "depart", "arrival"});
  TrafficFlow flow;
  flow.line = node.line;
  flow.edges = section.Names("edges");
  if (section.Has("depart_lane")) flow.depart_lane = section.Whole("depart_lane", 0, 63);
  if (section.Has("arrival_lane")) flow.arrival_lane = section.Whole("arrival_lane", 0, 63);
  flow.depart = section.Position("depart");
  flow.arrival = section.Position("arrival");
  return flow;
}

// Refuses what SUMO would answer with an abort in the middle of an episode.
void CheckBraking(const Section& profile) {
  if (profile.Has("sumo") && profile.Get("sumo").Find("default.emergencydecel") != nullptr) {
    throw BadScenario(profile.Get("sumo").line,
                      fmt::format("'{}.default.emergencydecel' is not for scenarios; set '{}' instead",
                                  profile.Name("sumo"), profile.Name("driver.emergencyDecel")));
  }
  if (!profile.Has("driver")) return;
  const YamlNode& driver = profile.Get("driver");
  const auto value = [&](const char* key, double otherwise) {
    const YamlNode* const node = driver.Find(key);
    if (node == nullptr) return otherwise;
    const auto number = AsNumber(*node);
    if (!number || *number <= 0.0) {
      throw BadScenario(node->line,
                        fmt::format("'{}.{}' is not a number above 0", profile.Name("driver"), key));
    }
    return *number;
  };
  const double decel = value("decel", kDriverDecel);
  const double emergency = value("emergencyDecel", kDriverEmergencyDecel);
  if (emergency > decel) return;
  throw BadScenario(driver.line,
                    fmt::format("'{0}.emergencyDecel' is {1:g}, '{0}.decel' is {2:g}: SUMO aborts unless the "
                                "first is larger; give more than {2:g}",
                                profile.Name("driver"), emergency, decel));
}

// What stands under `sumo`, names and files as SUMO is given them.
ProfileSettings::Options ReadOptions(const Section& profile, const fs::path& folder) {
  ProfileSettings::Options options;
  for (auto& [given, value] : profile.Pairs("sumo")) {
    const int line = profile.Get("sumo").line;
    const Result<std::string> name = ScenarioOption(given);
    if (!name) throw BadScenario(line, fmt::format("'{}': {}", profile.Name("sumo"), name.error().message));
    if (*name == kRouteFiles || *name == kAdditionalFiles) {
      const Result<std::string> files = FilesFrom(folder, value);
      if (!files)
        throw BadScenario(line,
                          fmt::format("'{}.{}': {}", profile.Name("sumo"), given, files.error().message));
      value = *files;
    }
    options.emplace_back(*name, std::move(value));
  }
  return options;
}

ProfileSettings ReadProfile(const Section& profiles, const std::string& name, const fs::path& folder) {
  const Section section(profiles.Get(name), profiles.Name(name), {"driver", "sumo"});
  ProfileSettings settings{ReadOptions(section, folder), section.Pairs("driver")};
  CheckBraking(section);
  return settings;
}

// Beside this scenario's own: never a way out of the folder of scenarios.
std::string FolderName(const YamlNode& node) {
  const std::string& name = node.text;
  if (name.empty() || name.find('/') != std::string::npos || name == "." || name == "..") {
    throw BadScenario(node.line,
                      fmt::format("'network': '{}' is not the name of another scenario", Shown(name)));
  }
  return name;
}

// `folder`: of the file. `network` is set to the name of the folder whose network is used.
Scenario ReadScenario(const YamlNode& root, const fs::path& folder, std::string& network) {
  const Section top(root, "", {"network", "warm_up_s", "ego", "traffic", "profiles"});
  Scenario scenario;
  if (top.Has("network")) network = FolderName(top.Get("network"));
  scenario.warm_up_s = top.Number("warm_up_s", 0, 3600);
  const Section ego(top.Get("ego"), "ego", {"lanes", "start_offset_m"});
  scenario.ego_line = ego.Get("lanes").line;
  scenario.ego_lanes = ego.Names("lanes");
  scenario.ego_start_offset_m = ego.Number("start_offset_m", 0, 1e6);
  const Section traffic(top.Get("traffic"), "traffic", {"driver_types", "flows"});
  scenario.driver_types = traffic.Whole("driver_types", 1, 1000);
  const YamlNode& flows = traffic.Get("flows");
  if (!flows.IsList()) throw BadScenario(flows.line, "'traffic.flows' must be a list");
  for (const YamlNode& flow : flows.items) scenario.flows.push_back(ReadFlow(flow, scenario.flows.size()));
  const Section profiles(top.Get("profiles"), "profiles", {"calibrated", "plain"});
  scenario.calibrated = ReadProfile(profiles, "calibrated", folder);
  scenario.plain = ReadProfile(profiles, "plain", folder);
  return scenario;
}

}  // namespace

fs::path ScenarioDirectory() {
  if (const auto folder = FromEnvironment(kScenariosVariable)) return *folder;
  std::error_code error;
  const fs::path executable = fs::read_symlink("/proc/self/exe", error);
  if (!error) {
    const fs::path shared = executable.parent_path().parent_path() / "share/dadrl/scenarios";
    if (fs::is_directory(shared, error)) return shared;
  }
  return DADRL_SCENARIO_DIRECTORY;
}

std::vector<std::string> ScenarioNames(const fs::path& directory) {
  std::vector<std::string> names;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(directory, error)) {
    if (fs::exists(entry.path() / kScenarioFile, error)) names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

ScenarioPlace PlaceOf(const fs::path& folder) {
  std::error_code error;
  fs::path whole = fs::absolute(folder, error).lexically_normal();
  if (!whole.has_filename()) whole = whole.parent_path();
  return {whole.filename().string(), whole.parent_path()};
}

Result<Scenario> LoadScenario(std::string_view name, const fs::path& directory) {
  const std::vector<std::string> names = ScenarioNames(directory);
  if (names.empty()) {
    return Fail(ErrorCode::kNotFound, "no scenario in {}; {}", directory.string(),
                FolderRemedy(kScenariosVariable, "build the project or set DADRL_SCENARIOS"));
  }
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    return Fail(ErrorCode::kInvalidArgument, "unknown scenario '{}'; the nearest is '{}' (there are: {})",
                name, NearestName(name, names), fmt::join(names, ", "));
  }
  const fs::path file = directory / name / kScenarioFile;
  try {
    std::string network(name);
    DADRL_ASSIGN_OR_RETURN(const YamlNode root, LoadYamlDocument(file));
    Scenario scenario = ReadScenario(root, file.parent_path(), network);
    scenario.name = name;
    scenario.file = file;
    scenario.network = directory / network / kNetworkFile;
    if (!fs::exists(scenario.network)) {
      return Fail(ErrorCode::kNotFound,
                  "{}: its network {} is missing; `dadrl scenario new` or netconvert makes one",
                  file.string(), scenario.network.string());
    }
    return scenario;
  } catch (const BadScenario& fault) {
    return Fail(ErrorCode::kInvalidArgument, "{}:{}", file.string(), fault.what());
  }
}

}  // namespace dadrl
