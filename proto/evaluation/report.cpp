#include "proto/evaluation/report.h"

#include <algorithm>
#include <tuple>

#include "proto/evaluation/summary_fields.h"
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
  figures.episodes = std::ssize(episodes);
  if (episodes.empty()) return figures;
  const double n = episodes.size();
  const auto measure = [&](Outcome outcome, double& rate, std::pair<double, double>& interval) {
    const int count = std::ranges::count(episodes, outcome, &EpisodeSummary::outcome);
    rate = count / n;
    interval = WilsonInterval(count, figures.episodes);
  };
  measure(Outcome::kSuccess, figures.success, figures.success_ci95);
  measure(Outcome::kCollision, figures.collision, figures.collision_ci95);
  measure(Outcome::kOffRoad, figures.off_road, figures.off_road_ci95);
  measure(Outcome::kStagnation, figures.stagnation, figures.stagnation_ci95);
  for (const SummaryField& field : kSummaryFields) {
    double sum = 0.0;
    for (const EpisodeSummary* episode : episodes) sum += episode->*field.value;
    figures.mean.*field.value = sum / n;
  }
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
