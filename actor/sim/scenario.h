// A scenario: a road network, its traffic, and the ego's way through it. One folder with a scenario.yaml (and
// the network's plain XML, unless it drives on another scenario's network); adding a scenario is adding a
// folder under actor/scenarios.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl {

enum class FlowPosition { kRandom, kLaneEnd };

// One vehicle of every driver type, looping over the same edges for ever.
struct TrafficFlow {
  int line = 0;  // of scenario.yaml
  std::vector<std::string> edges;
  int depart_lane = 0;
  int arrival_lane = 0;
  FlowPosition depart = FlowPosition::kRandom;
  FlowPosition arrival = FlowPosition::kRandom;
};

// How hard a driver brakes unless a profile says otherwise, m/s^2: in comfort (paper code), and in an
// emergency (SUMO's default). SUMO aborts the process unless the second is the larger.
constexpr double kDriverDecel = 4.5;
constexpr double kDriverEmergencyDecel = 9.0;

// What a traffic profile changes: SUMO options (name, value) and attributes of every driver type.
struct ProfileSettings {
  using Options = std::vector<std::pair<std::string, std::string>>;

  Options sumo_options;
  Options driver_attributes;
};

struct Scenario {
  std::string name;
  std::filesystem::path file;     // scenario.yaml
  int ego_line = 0;               // of the file: of ego.lanes
  std::filesystem::path network;  // .net.xml, built by netconvert
  double warm_up_s = 0.0;
  // Lanes to follow, junctions left out; the goal is the end of the last one.
  std::vector<std::string> ego_lanes;
  double ego_start_offset_m = 0.0;  // of the front bumper, along the first lane
  int driver_types = 1;
  std::vector<TrafficFlow> flows;
  ProfileSettings calibrated;
  ProfileSettings plain;

  int population() const { return driver_types * std::ssize(flows); }
  const ProfileSettings& profile(TrafficProfile which) const {
    return which == TrafficProfile::kCalibrated ? calibrated : plain;
  }
};

// Where the built scenarios are: $DADRL_SCENARIOS, else ../share/dadrl/scenarios beside the executable's
// folder, else the build tree.
std::filesystem::path ScenarioDirectory();

// Every scenario of `directory`, sorted.
std::vector<std::string> ScenarioNames(const std::filesystem::path& directory = ScenarioDirectory());

// The scenario whose folder is `folder`; an ending slash or "." does not matter.
struct ScenarioPlace {
  std::string name;
  std::filesystem::path directory;  // that it is in
};
ScenarioPlace PlaceOf(const std::filesystem::path& folder);

// kInvalidArgument: no such scenario (with the nearest name), or a broken scenario.yaml (file, line, key,
// what is expected). kNotFound: the network's file is missing. Lanes and edges are checked against the
// network by Simulation::Create.
Result<Scenario> LoadScenario(std::string_view name,
                              const std::filesystem::path& directory = ScenarioDirectory());

}  // namespace dadrl
