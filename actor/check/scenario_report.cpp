#include "actor/check/scenario_report.h"

#include <fmt/ranges.h>

#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>

namespace dadrl {
namespace {

double Kmh(double mps) { return 3.6 * mps; }

int Vehicles(const ScenarioReport& report) {
  int vehicles = 0;
  for (const FlowFacts& flow : report.flows) vehicles += flow.vehicles;
  return vehicles;
}

int Entered(const ScenarioReport& report) {
  int entered = 0;
  for (const FlowFacts& flow : report.flows) entered += flow.entered;
  return entered;
}

std::string Counted(int count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

std::string Distance(double metres) {
  return metres < 1000.0 ? fmt::format("{:.0f} m", metres) : fmt::format("{:.2f} km", metres / 1000.0);
}

std::string Limits(const RouteFacts& route) {
  const long low = std::lround(Kmh(route.min_limit_mps));
  const long high = std::lround(Kmh(route.max_limit_mps));
  return low == high ? fmt::format("{} km/h", low) : fmt::format("{} to {} km/h", low, high);
}

std::string Network(const ScenarioReport& report) {
  const Point extent = report.extent.high - report.extent.low;
  return fmt::format("{}: {}{}, {} for cars, {} together, {} x {}{}, {}", report.network.string(),
                     report.is_cut ? "near route and flows, the rest is left out: " : "",
                     Counted(report.survey.roads, "road"), Counted(report.survey.car_lanes, "lane"),
                     Distance(report.road_m), Distance(extent.x), Distance(extent.y),
                     report.has_levels ? ", of several heights" : "",
                     Counted(report.survey.traffic_lights, "traffic light"));
}

std::string Ignored(const ScenarioReport& report) {
  std::vector<std::string> kinds;
  for (const auto& [kind, count] : report.survey.ignored) kinds.push_back(Counted(count, kind));
  return kinds.empty() ? "nothing" : fmt::format("{}: closed to cars", fmt::join(kinds, ", "));
}

std::string RouteLine(const ScenarioReport& report) {
  const RouteFacts& route = report.route;
  return fmt::format("{}: {} from {:g} m on the first lane to the end of the last, {}, {}, {}",
                     fmt::join(route.lanes, " -> "), Distance(route.length_m), route.start_offset_m,
                     Counted(route.junctions, "junction"), Counted(route.lane_changes, "lane change"),
                     Limits(route));
}

std::string Ego(const ScenarioReport& report) {
  return fmt::format(
      "chooses a speed of 0 to {:g} m/s, and to keep its lane or change it, among {}; {:.1f} s to the goal "
      "at "
      "best, {:g} s at most",
      report.max_speed_mps, Counted(report.route.paths, "path"), report.route.shortest_s,
      report.time_limit_s);
}

std::string Traffic(const ScenarioReport& report) {
  return fmt::format("profile {}: {} in {}, {} on the road{} when the ego starts after {:g} s",
                     report.profile, Counted(Vehicles(report), "vehicle"),
                     Counted(static_cast<int>(report.flows.size()), "flow"), Entered(report),
                     report.others > 0 ? fmt::format(" with {} of its own files", report.others) : "",
                     report.warm_up_s);
}

std::string Cost(const ScenarioCost& cost) {
  return fmt::format(
      "here, each actor: {:.0f} MB, {:.2f} s to load, {:.3f} s to start an episode, {:.0f} steps a second",
      cost.memory_bytes / 1e6, cost.load_s, cost.reset_s, cost.steps_per_s);
}

void AppendLine(std::string& text, std::string_view name, const std::string& what) {
  fmt::format_to(std::back_inserter(text), "{:<9} {}\n", name, what);
}

}  // namespace

std::string ReportText(const ScenarioReport& report) {
  std::string text;
  AppendLine(text, "scenario", fmt::format("{}: {}", report.name, report.file.string()));
  AppendLine(text, "network", Network(report));
  AppendLine(text, "ignored", Ignored(report));
  AppendLine(text, "route", RouteLine(report));
  AppendLine(text, "ego", Ego(report));
  AppendLine(text, "traffic", Traffic(report));
  for (const FlowFacts& flow : report.flows) {
    AppendLine(
        text, "",
        fmt::format("{}: {}, {} of {} vehicles{}", fmt::join(flow.edges, " -> "), Distance(flow.length_m),
                    flow.entered, flow.vehicles, flow.meets_route ? "" : ", far from the route"));
  }
  AppendLine(text, "cost", Cost(report.cost));
  for (const std::string& warning : report.warnings) AppendLine(text, "warning", warning);
  AppendLine(text, "verdict", report.warnings.empty() ? "can be driven" : "can be driven, see the warnings");
  return text;
}

std::string ReportJson(const ScenarioReport& report) {
  using Json = nlohmann::ordered_json;
  Json flows = Json::array();
  for (const FlowFacts& flow : report.flows) {
    flows.push_back({{"edges", flow.edges},
                     {"length_m", flow.length_m},
                     {"vehicles", flow.vehicles},
                     {"entered", flow.entered},
                     {"meets_route", flow.meets_route}});
  }
  const NetworkSurvey& survey = report.survey;
  const RouteFacts& route = report.route;
  const Json json = {
      {"scenario", report.name},
      {"file", report.file.string()},
      {"drivable", true},
      {"network",
       {{"file", report.network.string()},
        {"roads", survey.roads},
        {"junctions", survey.junctions},
        {"traffic_lights", survey.traffic_lights},
        {"car_lanes", survey.car_lanes},
        {"car_lanes_m", report.road_m},
        {"extent_m",
         {report.extent.high.x - report.extent.low.x, report.extent.high.y - report.extent.low.y}},
        {"has_levels", report.has_levels},
        {"is_cut", report.is_cut},
        {"ignored", survey.ignored}}},
      {"route",
       {{"lanes", route.lanes},
        {"length_m", route.length_m},
        {"start_offset_m", route.start_offset_m},
        {"junctions", route.junctions},
        {"lane_changes", route.lane_changes},
        {"paths", route.paths},
        {"limits_mps", {route.min_limit_mps, route.max_limit_mps}},
        {"shortest_s", route.shortest_s},
        {"time_limit_s", report.time_limit_s},
        {"max_speed_mps", report.max_speed_mps}}},
      {"traffic",
       {{"profile", report.profile},
        {"warm_up_s", report.warm_up_s},
        {"vehicles", Vehicles(report)},
        {"entered", Entered(report)},
        {"others", report.others},
        {"flows", flows}}},
      {"cost",
       {{"memory_bytes", report.cost.memory_bytes},
        {"load_s", report.cost.load_s},
        {"reset_s", report.cost.reset_s},
        {"steps_per_s", report.cost.steps_per_s}}},
      {"warnings", report.warnings}};
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace dadrl
