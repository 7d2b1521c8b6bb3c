#include "proto/evaluation/report.h"

#include <algorithm>
#include <tuple>

#include "proto/evaluation/wilson.h"

namespace dadrl {
namespace {

double Median(std::vector<double> values) {
  std::ranges::sort(values);
  const size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

EvaluationFigures FiguresOf(const std::vector<const EpisodeSummary*>& episodes) {
  EvaluationFigures figures;
  figures.episodes = static_cast<int>(episodes.size());
  if (episodes.empty()) return figures;
  const auto n = static_cast<double>(episodes.size());
  const auto measure = [&](Outcome outcome, double& rate, std::pair<double, double>& interval) {
    const auto count = static_cast<int>(std::ranges::count(episodes, outcome, &EpisodeSummary::outcome));
    rate = count / n;
    interval = WilsonInterval(count, figures.episodes);
  };
  const auto mean = [&](double EpisodeSummary::*field) {
    double sum = 0.0;
    for (const EpisodeSummary* episode : episodes) sum += episode->*field;
    return sum / n;
  };
  measure(Outcome::kSuccess, figures.success, figures.success_ci95);
  measure(Outcome::kCollision, figures.collision, figures.collision_ci95);
  measure(Outcome::kOffRoad, figures.off_road, figures.off_road_ci95);
  measure(Outcome::kStagnation, figures.stagnation, figures.stagnation_ci95);
  figures.mean_return = mean(&EpisodeSummary::episode_return);
  figures.mean_speed_mps = mean(&EpisodeSummary::mean_speed_mps);
  figures.humanness_error = mean(&EpisodeSummary::humanness_error);
  figures.obstacle_cost = mean(&EpisodeSummary::obstacle_cost);
  figures.jerk_cost = mean(&EpisodeSummary::jerk_cost);
  figures.lane_offset_cost = mean(&EpisodeSummary::lane_offset_cost);
  figures.rule_violation = mean(&EpisodeSummary::rule_violation);
  figures.distance_to_destination = mean(&EpisodeSummary::distance_to_destination);
  figures.time_cost = mean(&EpisodeSummary::time_cost);
  figures.overall_score = mean(&EpisodeSummary::overall_score);
  std::vector<double> steps;
  for (const EpisodeSummary* episode : episodes) steps.push_back(episode->steps);
  figures.median_steps = Median(std::move(steps));
  return figures;
}

}  // namespace

EvaluationReport MakeReport(std::string scenario, std::string policy,
                            std::vector<EvaluatedEpisode> episodes) {
  std::ranges::sort(episodes, {}, [](const EvaluatedEpisode& episode) {
    return std::tie(episode.group, episode.summary.seed, episode.summary.scenario);
  });
  EvaluationReport report;
  report.scenario = std::move(scenario);
  report.policy = std::move(policy);
  report.episodes = std::move(episodes);

  std::vector<const EpisodeSummary*> all;
  for (size_t begin = 0; begin < report.episodes.size();) {
    SeedGroupReport group{report.episodes[begin].group, report.episodes[begin].summary.seed, {}};
    std::vector<const EpisodeSummary*> driven;
    size_t end = begin;
    for (; end < report.episodes.size() && report.episodes[end].group == group.group; ++end) {
      const EvaluatedEpisode& episode = report.episodes[end];
      if (episode.lost()) {
        ++report.lost;
      } else {
        driven.push_back(&episode.summary);
      }
    }
    group.figures = FiguresOf(driven);
    report.per_seed.push_back(group);
    all.insert(all.end(), driven.begin(), driven.end());
    begin = end;
  }
  report.all = FiguresOf(all);
  std::map<std::string, std::vector<const EpisodeSummary*>> by_scenario;
  for (const EpisodeSummary* episode : all) {
    by_scenario[episode->scenario].push_back(episode);
    if (episode->collision) ++report.collision_kinds[std::string(CollisionKind(*episode->collision))];
  }
  if (by_scenario.size() > 1) {
    for (const auto& [name, driven] : by_scenario) report.per_scenario.push_back({name, FiguresOf(driven)});
  }
  return report;
}

}  // namespace dadrl
