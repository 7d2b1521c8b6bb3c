#include "actor/sim/scenario.h"

#include <unistd.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include "actor/sim/sumo_options.h"
#include "common/config/config_schema.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScenarioFile = "scenario.yaml";
constexpr const char* kNetworkFile = "network.net.xml";

// A fault of the file: where, and what is expected there. Becomes a value in LoadScenario.
class BadScenario : public std::runtime_error {
 public:
  BadScenario(const YAML::Mark& mark, std::string_view what)
      : std::runtime_error(mark.is_null() ? std::string(what)
                                          : fmt::format("line {}: {}", mark.line + 1, what)) {}
};

// A map of the file with its dotted name; refuses keys that are not in `known`.
class Section {
 public:
  Section(YAML::Node node, std::string name, const std::vector<std::string>& known)
      : node_(std::move(node)), name_(std::move(name)) {
    if (!node_.IsMap()) {
      throw BadScenario(node_.Mark(), fmt::format("'{}' must hold 'key: value' lines", name_));
    }
    for (const auto& entry : node_) {
      const std::string key = entry.first.Scalar();
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      throw BadScenario(entry.first.Mark(), fmt::format("unknown key '{}'; the nearest is '{}'", Name(key),
                                                        Name(NearestName(key, known))));
    }
  }

  bool Has(const std::string& key) const { return static_cast<bool>(node_[key]); }

  YAML::Node Get(const std::string& key) const {
    if (!Has(key)) throw BadScenario(node_.Mark(), fmt::format("'{}' is missing", Name(key)));
    return node_[key];
  }

  double Number(const std::string& key, double min, double max) const {
    const YAML::Node value = Get(key);
    double number = 0.0;
    if (!value.IsScalar() || !YAML::convert<double>::decode(value, number) ||
        !(number >= min && number <= max)) {
      throw BadScenario(value.Mark(),
                        fmt::format("'{}' is not a number between {:g} and {:g}", Name(key), min, max));
    }
    return number;
  }

  int Whole(const std::string& key, int min, int max) const {
    const double number = Number(key, min, max);
    if (number != static_cast<int>(number)) {
      throw BadScenario(Get(key).Mark(), fmt::format("'{}' is not a whole number", Name(key)));
    }
    return static_cast<int>(number);
  }

  std::vector<std::string> Names(const std::string& key) const {
    const YAML::Node list = Get(key);
    std::vector<std::string> names;
    if (list.IsSequence()) {
      for (const YAML::Node& item : list) names.push_back(item.IsScalar() ? item.Scalar() : std::string());
    }
    if (names.empty() || std::any_of(names.begin(), names.end(), [](const auto& n) { return n.empty(); })) {
      throw BadScenario(list.Mark(), fmt::format("'{}' must be a list of names", Name(key)));
    }
    return names;
  }

  // Any keys with single values, as text.
  std::vector<std::pair<std::string, std::string>> Pairs(const std::string& key) const {
    std::vector<std::pair<std::string, std::string>> pairs;
    if (!Has(key)) return pairs;
    const YAML::Node map = Get(key);
    for (const auto& entry : map) {
      if (!map.IsMap() || !entry.second.IsScalar()) break;
      pairs.emplace_back(entry.first.Scalar(), entry.second.Scalar());
    }
    if (!map.IsMap() || pairs.size() != map.size()) {
      throw BadScenario(map.Mark(), fmt::format("'{}' must hold 'name: value' pairs", Name(key)));
    }
    return pairs;
  }

  FlowPosition Position(const std::string& key) const {
    if (!Has(key)) return FlowPosition::kRandom;
    const std::string text = Get(key).IsScalar() ? Get(key).Scalar() : "";
    if (text == "random") return FlowPosition::kRandom;
    if (text == "lane_end") return FlowPosition::kLaneEnd;
    throw BadScenario(Get(key).Mark(), fmt::format("'{}' is not one of: random, lane_end", Name(key)));
  }

  std::string Name(const std::string& key) const { return name_.empty() ? key : name_ + "." + key; }

 private:
  YAML::Node node_;
  std::string name_;
};

TrafficFlow ReadFlow(const YAML::Node& node, size_t index) {
  const Section section(node, fmt::format("traffic.flows[{}]", index),
                        {"edges", "depart_lane", "arrival_lane", "depart", "arrival"});
  TrafficFlow flow;
  flow.edges = section.Names("edges");
  if (section.Has("depart_lane")) flow.depart_lane = section.Whole("depart_lane", 0, 63);
  if (section.Has("arrival_lane")) flow.arrival_lane = section.Whole("arrival_lane", 0, 63);
  flow.depart = section.Position("depart");
  flow.arrival = section.Position("arrival");
  return flow;
}

// Refuses what SUMO would answer with an abort in the middle of an episode.
void CheckBraking(const Section& profile) {
  if (profile.Has("sumo") && profile.Get("sumo")["default.emergencydecel"]) {
    throw BadScenario(profile.Get("sumo").Mark(),
                      fmt::format("'{}.default.emergencydecel' is not for scenarios; set '{}' instead",
                                  profile.Name("sumo"), profile.Name("driver.emergencyDecel")));
  }
  if (!profile.Has("driver")) return;
  const YAML::Node driver = profile.Get("driver");
  const auto value = [&](const char* key, double otherwise) {
    if (!driver[key]) return otherwise;
    double number = 0.0;
    if (!YAML::convert<double>::decode(driver[key], number) || !(number > 0.0)) {
      throw BadScenario(driver[key].Mark(),
                        fmt::format("'{}.{}' is not a number above 0", profile.Name("driver"), key));
    }
    return number;
  };
  const double decel = value("decel", kDriverDecel);
  const double emergency = value("emergencyDecel", kDriverEmergencyDecel);
  if (emergency > decel) return;
  throw BadScenario(driver.Mark(),
                    fmt::format("'{0}.emergencyDecel' is {1:g}, '{0}.decel' is {2:g}: SUMO aborts unless the "
                                "first is larger; give more than {2:g}",
                                profile.Name("driver"), emergency, decel));
}

// What stands under `sumo`, names and files as SUMO is given them.
ProfileSettings::Options ReadOptions(const Section& profile, const fs::path& folder) {
  ProfileSettings::Options options;
  for (auto& [given, value] : profile.Pairs("sumo")) {
    const YAML::Mark mark = profile.Get("sumo").Mark();
    const Result<std::string> name = ScenarioOption(given);
    if (!name) throw BadScenario(mark, fmt::format("'{}': {}", profile.Name("sumo"), name.error().message));
    if (*name == kRouteFiles || *name == kAdditionalFiles) {
      const Result<std::string> files = FilesFrom(folder, value);
      if (!files)
        throw BadScenario(mark,
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

// `folder`: of the file. `network` is set to the name of the folder whose network is used.
Scenario ReadScenario(const YAML::Node& root, const fs::path& folder, std::string& network) {
  const Section top(root, "", {"network", "warm_up_s", "ego", "traffic", "profiles"});
  Scenario scenario;
  if (top.Has("network")) network = top.Get("network").as<std::string>();
  scenario.warm_up_s = top.Number("warm_up_s", 0, 3600);
  const Section ego(top.Get("ego"), "ego", {"lanes", "start_offset_m"});
  scenario.ego_lanes = ego.Names("lanes");
  scenario.ego_start_offset_m = ego.Number("start_offset_m", 0, 1e6);
  const Section traffic(top.Get("traffic"), "traffic", {"driver_types", "flows"});
  scenario.driver_types = traffic.Whole("driver_types", 1, 1000);
  const YAML::Node flows = traffic.Get("flows");
  if (!flows.IsSequence()) throw BadScenario(flows.Mark(), "'traffic.flows' must be a list");
  for (const YAML::Node& flow : flows) scenario.flows.push_back(ReadFlow(flow, scenario.flows.size()));
  const Section profiles(top.Get("profiles"), "profiles", {"calibrated", "plain"});
  scenario.calibrated = ReadProfile(profiles, "calibrated", folder);
  scenario.plain = ReadProfile(profiles, "plain", folder);
  return scenario;
}

}  // namespace

fs::path ScenarioDirectory() {
  if (const char* directory = std::getenv("DADRL_SCENARIOS"); directory != nullptr && *directory != '\0') {
    return directory;
  }
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

Result<Scenario> LoadScenario(std::string_view name, const fs::path& directory) {
  const std::vector<std::string> names = ScenarioNames(directory);
  if (names.empty()) {
    return Fail(ErrorCode::kNotFound, "no scenario in {}; build the project or set DADRL_SCENARIOS",
                directory.string());
  }
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    return Fail(ErrorCode::kInvalidArgument, "unknown scenario '{}'; the nearest is '{}' (there are: {})",
                name, NearestName(name, names), fmt::join(names, ", "));
  }
  const fs::path file = directory / name / kScenarioFile;
  try {
    std::string network(name);
    Scenario scenario = ReadScenario(YAML::LoadFile(file), file.parent_path(), network);
    scenario.name = name;
    scenario.network = directory / network / kNetworkFile;
    if (!fs::exists(scenario.network)) {
      return Fail(ErrorCode::kNotFound, "{}: its network {} is missing; build the target dadrl_scenarios",
                  file.string(), scenario.network.string());
    }
    return scenario;
  } catch (const std::exception& exception) {
    return Fail(ErrorCode::kInvalidArgument, "{}: {}", file.string(), exception.what());
  }
}

}  // namespace dadrl
