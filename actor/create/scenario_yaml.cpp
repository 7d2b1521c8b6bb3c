#include "actor/create/scenario_yaml.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <iterator>

namespace dadrl {
namespace {

// Ids of maps begin with '-' and have '#' in them.
std::string Quoted(const std::string& name) {
  const bool plain = std::ranges::all_of(
      name, [](unsigned char c) { return std::isalpha(c) != 0 || c == '_' || std::isdigit(c) != 0; });
  const bool number = std::ranges::none_of(name, [](unsigned char c) { return std::isalpha(c) != 0; });
  if (plain && !number) return name;
  std::string quoted = "'";
  for (const char c : name) quoted += c == '\'' ? std::string("''") : std::string(1, c);
  return quoted + "'";
}

std::string List(const std::vector<std::string>& names) {
  std::vector<std::string> quoted;
  for (const std::string& name : names) quoted.push_back(Quoted(name));
  return fmt::format("[{}]", fmt::join(quoted, ", "));
}

const char* Word(FlowPosition position) { return position == FlowPosition::kRandom ? "random" : "lane_end"; }

constexpr const char* kProfiles = R"(profiles:
  # Drivers who react every half second and brake less hard, as in the scenarios that ship.
  calibrated:
    driver: {actionStepLength: 0.5, emergencyDecel: 5.0}
    sumo: {lanechange.duration: 3}
  plain:
    sumo: {lanechange.duration: 3}
)";

}  // namespace

std::string ScenarioYaml(const Scenario& scenario, const std::string& first_line) {
  std::string text = fmt::format(
      "# {}\nwarm_up_s: {:g}\nego:\n  lanes: {}\n  start_offset_m: {:g}\ntraffic:\n  driver_types: {}\n",
      first_line, scenario.warm_up_s, List(scenario.ego_lanes), scenario.ego_start_offset_m,
      scenario.driver_types);
  text += scenario.flows.empty() ? "  flows: []\n" : "  flows:\n";
  for (const TrafficFlow& flow : scenario.flows) {
    fmt::format_to(std::back_inserter(text),
                   "    - {{edges: {}, depart_lane: {}, arrival_lane: {}, depart: {}, arrival: {}}}\n",
                   List(flow.edges), flow.depart_lane, flow.arrival_lane, Word(flow.depart),
                   Word(flow.arrival));
  }
  return text + kProfiles;
}

}  // namespace dadrl
