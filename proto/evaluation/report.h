// The result of an evaluation: rates with intervals over all episodes, and a row for each seed group (design,
// section 3: `dadrl evaluate`).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "proto/evaluation/episode_line.h"

namespace dadrl {

// Means over a set of driven episodes; rates are fractions of 1.
struct EvaluationFigures {
  int episodes = 0;
  double success = 0.0;
  double collision = 0.0;
  double off_road = 0.0;
  double stagnation = 0.0;
  double mean_return = 0.0;
  double median_steps = 0.0;  // of all episodes
  double mean_speed_mps = 0.0;
  double humanness_error = 0.0;
  double obstacle_cost = 0.0;
  double jerk_cost = 0.0;
  double lane_offset_cost = 0.0;
  double rule_violation = 0.0;
  double distance_to_destination = 0.0;
  double time_cost = 0.0;
  double overall_score = 0.0;
};

struct SeedGroupReport {
  int group = 0;
  uint64_t first_seed = 0;
  EvaluationFigures figures;
};

struct EvaluationReport {
  std::string scenario;
  std::string policy;
  EvaluationFigures all;
  // Wilson, 95 %, of the rates in `all`.
  std::pair<double, double> success_ci95, collision_ci95, off_road_ci95, stagnation_ci95;
  std::vector<SeedGroupReport> per_seed;  // by group
  // Every episode by (group, seed), lost ones included: these count in no rate.
  std::vector<EvaluatedEpisode> episodes;
  int lost = 0;
};

// The same report whatever order the episodes came in.
EvaluationReport MakeReport(std::string scenario, std::string policy, std::vector<EvaluatedEpisode> episodes);

// One JSON object without a line break; the keys of design section 3 and more.
std::string ReportJson(const EvaluationReport& report);
// A few lines of text for a terminal, line break at the end.
std::string ReportTable(const EvaluationReport& report);
// A row an episode, with a header line: also the format of a run's episodes.csv.
std::string ReportCsv(const EvaluationReport& report);

// The pieces of ReportCsv, with line breaks.
std::string EpisodeCsvHeader();
std::string EpisodeCsvRow(const std::string& scenario, const std::string& policy,
                          const EvaluatedEpisode& episode);

}  // namespace dadrl
