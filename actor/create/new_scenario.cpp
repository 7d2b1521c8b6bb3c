#include "actor/create/new_scenario.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <system_error>
#include <utility>

#include "actor/check/check_command.h"
#include "actor/create/lane_search.h"
#include "actor/create/netconvert.h"
#include "actor/create/scenario_yaml.h"
#include "actor/create/traffic_choice.h"
#include "actor/sim/sumo_network.h"
#include "common/config/config_schema.h"
#include "common/io/atomic_file.h"
#include "common/util/environment.h"
#include "common/util/shown.h"
#include "common/util/utf8.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;

// The ego has so much road before its first junction, and traffic so long to form.
constexpr double kApproachMetres = 60.0;
constexpr double kWarmUp = 30.0;
constexpr size_t kMostNameBytes = 64;
constexpr size_t kMostEdgesListed = 30;

// It becomes a folder, a word on command lines, and part of runs' names.
Status CheckName(const std::string& name) {
  const auto refuse = [&](std::string_view why) {
    return Fail(ErrorCode::kInvalidArgument, "NAME: '{}' {}; a name like side_street does", Shown(name), why);
  };
  if (name.empty()) return refuse("is empty");
  if (name.size() > kMostNameBytes) return refuse(fmt::format("is longer than {} bytes", kMostNameBytes));
  if (name.find('/') != std::string::npos)
    return refuse("has a '/' in it (--into says where the folder is made)");
  if (name.front() == '.' || name.front() == '-')
    return refuse(fmt::format("begins with '{}'", name.front()));
  if (name == kAllScenarios) return refuse("stands for every scenario");
  if (!IsPrintableUtf8(name)) return refuse("has characters in it that are not text");
  return {};
}

fs::path FolderOfScenarios(const NewScenarioOptions& options) {
  if (!options.into.empty()) return options.into;
  return FromEnvironment(kScenariosVariable).value_or("scenarios");
}

// Removed unless it was moved to its place.
class DraftFolder {
 public:
  static Result<DraftFolder> Create(const fs::path& into) {
    std::error_code error;
    fs::create_directories(into, error);
    std::string path = (into / ".new-XXXXXX").string();
    if (!error && mkdtemp(path.data()) != nullptr) return DraftFolder(path);
    return Fail(ErrorCode::kInternal, "--into: cannot make a folder in {}: {}", into.string(),
                error ? error.message() : std::system_category().message(errno));
  }
  explicit DraftFolder(fs::path path) : path_(std::move(path)) {}
  DraftFolder(DraftFolder&& other) noexcept : path_(std::exchange(other.path_, {})) {}
  DraftFolder& operator=(DraftFolder&&) = delete;
  ~DraftFolder() {
    std::error_code error;
    if (!path_.empty()) fs::remove_all(path_, error);
  }

  const fs::path& path() const { return path_; }

  Status MoveTo(const fs::path& place) {
    std::error_code error;
    fs::permissions(path_, fs::perms(0755), error);
    fs::rename(path_, place, error);
    if (error) {
      return Fail(ErrorCode::kInternal, "cannot make {}: {}", place.string(), error.message());
    }
    path_.clear();
    return {};
  }

 private:
  fs::path path_;
};

// For whoever does not know yet.
Status AskForEdges(const RoadMap& map) {
  std::vector<std::string> edges;
  std::vector<std::string> shown;
  for (const Lane& lane : map.lanes()) {
    if (lane.internal || (!edges.empty() && edges.back() == lane.edge)) continue;
    edges.push_back(lane.edge);
    if (shown.size() == kMostEdgesListed) continue;
    const std::string street = StreetName(lane.edge);
    shown.push_back(
        fmt::format("{}{} ({:.0f} m)", lane.edge, street.empty() ? "" : " " + street, lane.centre.length()));
  }
  return Fail(ErrorCode::kInvalidArgument, "--from and --to are needed; the edges for cars: {}{}",
              fmt::join(shown, ", "),
              edges.size() > shown.size()
                  ? fmt::format(" and {} more (netedit shows them on a map)", edges.size() - shown.size())
                  : "");
}

Result<Scenario> Design(const NewScenarioOptions& options, const RoadMap& map) {
  if (options.from.empty() || options.to.empty()) {
    DADRL_RETURN_IF_ERROR(AskForEdges(map));
  }
  Scenario scenario;
  scenario.warm_up_s = kWarmUp;
  DADRL_ASSIGN_OR_RETURN(scenario.ego_lanes, FindLanes(map, options.from, options.to));
  const Lane& first = map.lane(map.FindLane(scenario.ego_lanes.front()));
  const double length = first.centre.length();
  scenario.ego_start_offset_m = std::round(std::max(std::min(10.0, length / 2), length - kApproachMetres));
  TrafficChoice traffic = ChooseTraffic(map, scenario.ego_lanes);
  scenario.flows = std::move(traffic.flows);
  scenario.driver_types = traffic.driver_types;
  return scenario;
}

std::string FirstLine(const NewScenarioOptions& options) {
  return fmt::format("From edge {} to edge {} of {}. Flows and density are guesses: change them.",
                     Shown(options.from), Shown(options.to),
                     Shown(fs::path(options.osm.empty() ? options.net : options.osm).filename().string()));
}

Status MakeFolder(const NewScenarioOptions& options, const fs::path& into, const fs::path& place) {
  DADRL_ASSIGN_OR_RETURN(DraftFolder draft, DraftFolder::Create(into));
  const fs::path network = draft.path() / "network.net.xml";
  const RoadSource source{.file = options.osm.empty() ? options.net : options.osm,
                          .osm = !options.osm.empty(),
                          .left_hand = options.left_hand};
  DADRL_RETURN_IF_ERROR(BuildNetwork(source, network));
  DADRL_ASSIGN_OR_RETURN(const RoadMap map, LoadRoadMap(network));
  DADRL_ASSIGN_OR_RETURN(const Scenario scenario, Design(options, map));
  DADRL_RETURN_IF_ERROR(WriteFileAtomically(draft.path() / "scenario.yaml",
                                            std::string_view(ScenarioYaml(scenario, FirstLine(options)))));
  return draft.MoveTo(place);
}

// As a shell takes it.
std::string ShellWord(const std::string& word) {
  const bool plain = std::ranges::all_of(word, [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.' || c == '/';
  });
  if (plain) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

void PrintNextSteps(const fs::path& into, const std::string& name) {
  const std::string variable = fmt::format("DADRL_SCENARIOS={}", ShellWord(into.string()));
  const std::string word = ShellWord(name);
  fmt::print(
      "\nFlows and density are guesses. Look, let the scripted drivers say whether it is a task, train:\n"
      "  dadrl scenario check {} --picture {}.svg\n"
      "  {} dadrl evaluate --policy idm --scenario {} --episodes 20 --seeds 1\n"
      "  {} dadrl train {} --minutes 20\n",
      ShellWord((into / name).string()), word, variable, word, variable, word);
}

}  // namespace

void NewScenarioOptions::AddTo(CLI::App& app) {
  app.add_option("name", name, "Of the folder that is made")->required()->type_name("NAME");
  auto* const net_option =
      app.add_option("--net", net, "SUMO's network (.net.xml), or one of the files of plain XML (.nod.xml)")
          ->type_name("FILE");
  app.add_option("--osm", osm, "OpenStreetMap extract")->type_name("FILE")->excludes(net_option);
  app.add_option("--from", from, "Edge that the ego starts on; without, the edges are listed")
      ->type_name("EDGE");
  app.add_option("--to", to, "Edge at whose end its goal is")->type_name("EDGE");
  app.add_option("--into", into, "Folder of scenarios (default: $DADRL_SCENARIOS, else scenarios)")
      ->type_name("DIR");
  app.add_flag("--left-hand", left_hand, "One drives on the left (of plain XML and OpenStreetMap)");
}

Result<int> RunNewScenario(const NewScenarioOptions& options) {
  DADRL_RETURN_IF_ERROR(CheckName(options.name));
  if (options.net.empty() == options.osm.empty()) {
    return Fail(ErrorCode::kInvalidArgument, "the road is missing: give --net FILE or --osm FILE");
  }
  const fs::path into = FolderOfScenarios(options);
  const fs::path place = into / options.name;
  std::error_code error;
  if (fs::exists(fs::symlink_status(place, error))) {
    return Fail(ErrorCode::kInvalidArgument, "{} is there already; take another NAME, or remove it",
                place.string());
  }
  DADRL_RETURN_IF_ERROR(MakeFolder(options, into, place));
  fmt::print("made      {}\n", place.string());
  DADRL_RETURN_IF_ERROR(PrintCheck(options.name, into, {}));
  PrintNextSteps(into, options.name);
  return 0;
}

}  // namespace dadrl
