// The result of an evaluation: rates with intervals over all episodes, and a row for each seed group (design,
// section 3: `dadrl evaluate`).
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "proto/evaluation/episode_line.h"

namespace dadrl {

// Of a set of driven episodes; rates are fractions of 1.
struct EvaluationFigures {
  int episodes = 0;
  double success = 0.0;
  double collision = 0.0;
  double off_road = 0.0;
  double stagnation = 0.0;
  double median_steps = 0.0;  // of all episodes
  EpisodeMeasures mean;
  // Wilson, 95 %, of the rates.
  std::pair<double, double> success_ci95{0, 1}, collision_ci95{0, 1}, off_road_ci95{0, 1},
      stagnation_ci95{0, 1};
};

struct SeedGroupReport {
  int group = 0;
  uint64_t first_seed = 0;
  EvaluationFigures figures;
};

struct ScenarioReport {
  std::string scenario;
  EvaluationFigures figures;
};

struct EvaluationReport {
  std::string scenario;
  std::string policy;
  EvaluationFigures all;
  std::map<std::string, int> collision_kinds;  // CollisionKind: how many
  std::vector<SeedGroupReport> per_seed;       // by group
  std::vector<ScenarioReport> per_scenario;    // by name; empty when all are of one scenario
  // Every episode by (group, seed, scenario), lost ones included: these count in no rate.
  std::vector<EvaluatedEpisode> episodes;
  int lost = 0;
};

// The same report whatever order the episodes came in. `scenario` is a name or "all".
EvaluationReport MakeReport(std::string scenario, std::string policy, std::vector<EvaluatedEpisode> episodes);

// One JSON object without a line break; the keys of design section 3 and more.
std::string ReportJson(const EvaluationReport& report);
// A few lines of text for a terminal, line break at the end.
std::string ReportTable(const EvaluationReport& report);
// A row an episode, with a header line.
std::string ReportCsv(const EvaluationReport& report);

}  // namespace dadrl
