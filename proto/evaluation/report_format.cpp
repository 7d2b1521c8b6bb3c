#include <fmt/format.h>

#include <iterator>
#include <nlohmann/json.hpp>

#include "proto/evaluation/report.h"
#include "proto/evaluation/summary_fields.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

void AddFigures(const EvaluationFigures& figures, Json& json) {
  json["episodes"] = figures.episodes;
  json["success"] = figures.success;
  json["collision"] = figures.collision;
  json["off_road"] = figures.off_road;
  json["stagnation"] = figures.stagnation;
  json["mean_return"] = figures.mean_return;
  json["median_steps"] = figures.median_steps;
  json["mean_speed_mps"] = figures.mean_speed_mps;
  json["humanness_error"] = figures.humanness_error;
  json["obstacle_cost"] = figures.obstacle_cost;
  json["jerk_cost"] = figures.jerk_cost;
  json["lane_offset_cost"] = figures.lane_offset_cost;
  json["rule_violation"] = figures.rule_violation;
  json["distance_to_destination"] = figures.distance_to_destination;
  json["time_cost"] = figures.time_cost;
  json["overall_score"] = figures.overall_score;
}

Json IntervalJson(std::pair<double, double> interval) {
  return Json::array({interval.first, interval.second});
}

std::string Percent(double rate) { return fmt::format("{:.1f}", 100 * rate); }

std::string PercentRange(std::pair<double, double> range) {
  return fmt::format("{:.1f}-{:.1f}", 100 * range.first, 100 * range.second);
}

constexpr std::string_view kRow = "{:<14} {:>11} {:>11} {:>11} {:>11} {:>8} {:>7} {:>10} {:>8}\n";

std::string FiguresRow(const std::string& name, const EvaluationFigures& figures) {
  return fmt::format(kRow, name, Percent(figures.success), Percent(figures.collision),
                     Percent(figures.off_road), Percent(figures.stagnation),
                     fmt::format("{:.2f}", figures.mean_return), fmt::format("{:.0f}", figures.median_steps),
                     fmt::format("{:.3f}", figures.humanness_error),
                     fmt::format("{:.3f}", figures.overall_score));
}

std::string Quoted(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"') quoted += '"';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

std::string ReportJson(const EvaluationReport& report) {
  Json json;
  json["scenario"] = report.scenario;
  json["policy"] = report.policy;
  AddFigures(report.all, json);
  json["success_ci95"] = IntervalJson(report.success_ci95);
  json["collision_ci95"] = IntervalJson(report.collision_ci95);
  json["off_road_ci95"] = IntervalJson(report.off_road_ci95);
  json["stagnation_ci95"] = IntervalJson(report.stagnation_ci95);
  json["lost_episodes"] = report.lost;
  json["per_seed"] = Json::array();
  for (const SeedGroupReport& group : report.per_seed) {
    Json row;
    row["first_seed"] = group.first_seed;
    AddFigures(group.figures, row);
    json["per_seed"].push_back(std::move(row));
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
  text += FiguresRow("all", report.all);
  text += fmt::format(kRow, "95 % interval", PercentRange(report.success_ci95),
                      PercentRange(report.collision_ci95), PercentRange(report.off_road_ci95),
                      PercentRange(report.stagnation_ci95), "", "", "error", "score");
  if (report.lost > 0) {
    text += fmt::format("{} episodes were lost to the simulator and count in no figure.\n", report.lost);
  }
  return text;
}

std::string EpisodeCsvHeader() {
  std::string text = "scenario,policy,group,seed,outcome,steps";
  for (const SummaryField& field : kSummaryFields) text += fmt::format(",{}", field.name);
  return text + ",error\n";
}

std::string EpisodeCsvRow(const std::string& scenario, const std::string& policy,
                          const EvaluatedEpisode& episode) {
  std::string text =
      fmt::format("{},{},{},{},", scenario, Quoted(policy), episode.group, episode.summary.seed);
  if (episode.lost()) {
    text += std::string(kSummaryFields.size() + 2, ',') + Quoted(episode.error);
  } else {
    text += fmt::format("{},{}", OutcomeName(episode.summary.outcome), episode.summary.steps);
    for (const SummaryField& field : kSummaryFields) {
      fmt::format_to(std::back_inserter(text), ",{}", episode.summary.*field.value);
    }
    text += ',';
  }
  return text + '\n';
}

std::string ReportCsv(const EvaluationReport& report) {
  std::string text = EpisodeCsvHeader();
  for (const EvaluatedEpisode& episode : report.episodes) {
    text += EpisodeCsvRow(report.scenario, report.policy, episode);
  }
  return text;
}

}  // namespace dadrl
