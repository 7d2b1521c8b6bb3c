#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>
#include <nlohmann/json.hpp>
#include <span>

#include "common/util/csv.h"
#include "proto/evaluation/report.h"
#include "proto/evaluation/summary_fields.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

Json IntervalJson(std::pair<double, double> interval) {
  return Json::array({interval.first, interval.second});
}

void AddFigures(const EvaluationFigures& figures, Json& json) {
  json["episodes"] = figures.episodes;
  json["success"] = figures.success;
  json["collision"] = figures.collision;
  json["off_road"] = figures.off_road;
  json["stagnation"] = figures.stagnation;
  json["mean_return"] = figures.mean.episode_return;
  json["median_steps"] = figures.median_steps;
  // Behind the return and the progress, which is no figure.
  for (const SummaryField& field : std::span(kSummaryFields).subspan(2)) {
    json[field.name] = figures.mean.*field.value;
  }
  json["success_ci95"] = IntervalJson(figures.success_ci95);
  json["collision_ci95"] = IntervalJson(figures.collision_ci95);
  json["off_road_ci95"] = IntervalJson(figures.off_road_ci95);
  json["stagnation_ci95"] = IntervalJson(figures.stagnation_ci95);
}

std::string Percent(double rate) { return fmt::format("{:.1f}", 100 * rate); }

std::string PercentRange(std::pair<double, double> range) {
  return fmt::format("{:.1f}-{:.1f}", 100 * range.first, 100 * range.second);
}

constexpr std::string_view kRow = "{:<14} {:>11} {:>11} {:>11} {:>11} {:>8} {:>7} {:>10} {:>8}\n";

std::string FiguresRow(const std::string& name, const EvaluationFigures& figures) {
  return fmt::format(
      kRow, name, Percent(figures.success), Percent(figures.collision), Percent(figures.off_road),
      Percent(figures.stagnation), fmt::format("{:.2f}", figures.mean.episode_return),
      fmt::format("{:.0f}", figures.median_steps), fmt::format("{:.3f}", figures.mean.humanness_error),
      fmt::format("{:.3f}", figures.mean.overall_score));
}

// "collisions: 3 crossing, 1 ran_into", the most frequent first; empty without collisions.
std::string KindsLine(const std::map<std::string, int>& kinds) {
  std::vector<std::pair<std::string, int>> rows(kinds.begin(), kinds.end());
  std::ranges::stable_sort(rows, std::ranges::greater(), &std::pair<std::string, int>::second);
  std::string text;
  for (const auto& [kind, count] : rows) {
    text += fmt::format("{} {} {}", text.empty() ? "collisions:" : ",", count, kind);
  }
  return text.empty() ? text : text + '\n';
}

constexpr std::string_view kCollisionColumns =
    ",collision_kind,contact_side,ego_speed_mps,other_speed_mps,relative_heading_rad,junction,lane_changer";

std::string CollisionColumns(const std::optional<CollisionSummary>& collision) {
  if (!collision) return std::string(static_cast<size_t>(std::ranges::count(kCollisionColumns, ',')), ',');
  return fmt::format(",{},{},{},{},{},{},{}", CollisionKind(*collision), ContactSideName(collision->side),
                     collision->ego_speed_mps, collision->other_speed_mps, collision->relative_heading_rad,
                     collision->junction, LaneChangerName(collision->lane_changer));
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

std::string CsvHeader() {
  std::string text = "scenario,policy,group,seed,outcome,steps";
  for (const SummaryField& field : kSummaryFields) text += fmt::format(",{}", field.name);
  return text.append(kCollisionColumns) + ",error\n";
}

std::string CsvRow(const std::string& policy, const EvaluatedEpisode& episode) {
  std::string text = fmt::format("{},{},{},{},", CsvCell(episode.summary.scenario), Quoted(policy),
                                 episode.group, episode.summary.seed);
  if (episode.lost()) {
    text += std::string(kSummaryFields.size() + 1, ',') + CollisionColumns(std::nullopt) + ',' +
            Quoted(episode.error);
  } else {
    text += fmt::format("{},{}", OutcomeName(episode.summary.outcome), episode.summary.steps);
    for (const SummaryField& field : kSummaryFields) {
      fmt::format_to(std::back_inserter(text), ",{}", episode.summary.*field.value);
    }
    text += CollisionColumns(episode.summary.collision) + ',';
  }
  return text + '\n';
}

}  // namespace

std::string ReportJson(const EvaluationReport& report) {
  Json json;
  json["scenario"] = report.scenario;
  json["policy"] = report.policy;
  AddFigures(report.all, json);
  json["collision_kinds"] = report.collision_kinds;
  json["lost_episodes"] = report.lost;
  json["per_seed"] = Json::array();
  for (const SeedGroupReport& group : report.per_seed) {
    Json row;
    row["first_seed"] = group.first_seed;
    AddFigures(group.figures, row);
    json["per_seed"].push_back(std::move(row));
  }
  for (const ScenarioReport& scenario : report.per_scenario) {
    Json row;
    row["scenario"] = scenario.scenario;
    AddFigures(scenario.figures, row);
    json["per_scenario"].push_back(std::move(row));
  }
  return json.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string ReportTable(const EvaluationReport& report) {
  std::string text = fmt::format("{}, policy {}: {} episodes of unseen traffic\n", report.scenario,
                                 report.policy, report.all.episodes);
  text += fmt::format(kRow, "%", "success", "collision", "off-road", "stagnation", "return", "steps",
                      "humanness", "overall");
  for (const SeedGroupReport& group : report.per_seed) {
    text += FiguresRow(fmt::format("seed {}", group.first_seed), group.figures);
  }
  for (const ScenarioReport& scenario : report.per_scenario) {
    text += FiguresRow(scenario.scenario, scenario.figures);
  }
  text += FiguresRow("all", report.all);
  text += fmt::format(kRow, "95 % interval", PercentRange(report.all.success_ci95),
                      PercentRange(report.all.collision_ci95), PercentRange(report.all.off_road_ci95),
                      PercentRange(report.all.stagnation_ci95), "", "", "error", "score");
  text += KindsLine(report.collision_kinds);
  if (report.lost > 0) {
    text += fmt::format("{} episodes were lost to the simulator and count in no figure.\n", report.lost);
  }
  return text;
}

std::string ReportCsv(const EvaluationReport& report) {
  std::string text = CsvHeader();
  for (const EvaluatedEpisode& episode : report.episodes) text += CsvRow(report.policy, episode);
  return text;
}

}  // namespace dadrl
