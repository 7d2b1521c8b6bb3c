#include "actor/check/scenario_warnings.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace dadrl {
namespace {

constexpr double kMeetMetres = 15.0;
constexpr double kSampleMetres = 5.0;
// The ego is an obstacle where others may drive so much faster.
constexpr double kFasterThanEgo = 3.0;

using Warnings = std::vector<std::string>;

void WarnOfRoute(const ScenarioReport& report, Warnings& warnings) {
  const RouteFacts& route = report.route;
  if (route.shortest_s >= report.time_limit_s) {
    warnings.push_back(fmt::format(
        "the goal cannot be reached: {:.0f} m take {:.0f} s at task.max_speed_mps={:g}, an episode ends "
        "after "
        "{:g} s; give --set task.max_steps={:.0f} or more, a higher task.max_speed_mps, or shorten ego.lanes",
        route.length_m, route.shortest_s, report.max_speed_mps, report.time_limit_s,
        std::ceil(2 * route.shortest_s) * 10));
  }
  if (route.max_limit_mps > kFasterThanEgo * report.max_speed_mps) {
    warnings.push_back(
        fmt::format("others may drive {:.0f} km/h on the route, the ego at most {:.0f}; give --set "
                    "task.max_speed_mps={:.0f} (40 at most)",
                    3.6 * route.max_limit_mps, 3.6 * report.max_speed_mps,
                    std::min(40.0, std::ceil(route.max_limit_mps))));
  }
  Warnings stretched;
  for (const std::string& lane : route.lanes) {
    if (std::ranges::find(report.survey.stretched, lane) != report.survey.stretched.end()) {
      stretched.push_back(lane);
    }
  }
  if (!stretched.empty()) {
    warnings.push_back(
        fmt::format("SUMO's length of {} is not the one drawn: speeds and gaps there are not those one sees; "
                    "take the attribute 'length' out of its edge",
                    fmt::join(stretched, ", ")));
  }
}

void WarnOfTraffic(const ScenarioReport& report, Warnings& warnings) {
  if (report.flows.empty() && report.others == 0) {
    warnings.emplace_back("no traffic: give traffic.flows some edges");
  } else if (report.others == 0 && std::ranges::none_of(report.flows, &FlowFacts::meets_route)) {
    warnings.push_back(fmt::format(
        "no flow comes within {:.0f} m of the ego's route: there is nobody to give way to", kMeetMetres));
  }
  int vehicles = 0;
  int entered = 0;
  for (const FlowFacts& flow : report.flows) {
    vehicles += flow.vehicles;
    entered += flow.entered;
  }
  // A few always wait for room.
  if (2 * entered < vehicles && !report.has_levels) {
    warnings.push_back(
        fmt::format("{} of {} vehicles found no room before the ego starts; give a longer warm_up_s, fewer "
                    "traffic.driver_types, or flows that begin on other edges",
                    vehicles - entered, vehicles));
  }
}

}  // namespace

std::vector<const Lane*> LanesOfFlow(const RoadMap& map, const TrafficFlow& flow) {
  std::vector<const Lane*> lanes;
  for (const std::string& edge : flow.edges) {
    const auto of_edge = map.LanesOfEdge(edge);
    if (!of_edge.empty()) lanes.push_back(&map.lane(of_edge.front()));
  }
  return lanes;
}

double FlowLength(const RoadMap& map, const TrafficFlow& flow) {
  double length = 0.0;
  for (const Lane* lane : LanesOfFlow(map, flow)) length += lane->centre.length();
  return length;
}

bool MeetsRoute(const RoadMap& map, const TrafficFlow& flow, const Route& route) {
  return std::ranges::any_of(LanesOfFlow(map, flow), [&](const Lane* lane) {
    for (double s = 0.0; s <= lane->centre.length(); s += kSampleMetres) {
      const Polyline::Projection at = route.centre().Project(lane->centre.At(s));
      const double height = lane->centre.ElevationAt(s) - route.centre().ElevationAt(at.s);
      if (at.distance <= kMeetMetres && OnOneLevel(height, at.distance)) return true;
    }
    return false;
  });
}

std::vector<std::string> WarningsOf(const ScenarioReport& report) {
  Warnings warnings;
  WarnOfRoute(report, warnings);
  WarnOfTraffic(report, warnings);
  return warnings;
}

}  // namespace dadrl
