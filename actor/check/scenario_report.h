// What there is to know about a scenario before anybody trains on it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "actor/render/road_picture.h"
#include "actor/sim/network_survey.h"

namespace dadrl {

struct RouteFacts {
  std::vector<std::string> lanes;  // as scenario.yaml names them
  double length_m = 0.0;
  double start_offset_m = 0.0;
  int junctions = 0;     // driven through
  int lane_changes = 0;  // the route cannot be driven without
  int paths = 0;         // lanes and branches that the ego can choose along it
  double min_limit_mps = 0.0;
  double max_limit_mps = 0.0;
  double shortest_s = 0.0;  // at task.max_speed_mps
};

struct FlowFacts {
  std::vector<std::string> edges;
  double length_m = 0.0;
  int vehicles = 0;
  int entered = 0;  // when the ego starts
  bool meets_route = false;
};

// Measured here and now.
struct ScenarioCost {
  double memory_bytes = 0.0;  // of an actor's simulation, libraries included
  double load_s = 0.0;        // network, map and senses, once a process
  double reset_s = 0.0;       // an episode's start, warm-up included
  double steps_per_s = 0.0;   // simulation steps of an episode, observed as in training
};

struct ScenarioReport {
  std::string name;
  std::filesystem::path file;
  std::filesystem::path network;
  NetworkSurvey survey;
  double road_m = 0.0;  // of all car lanes
  Extent extent;
  bool has_levels = false;
  bool is_cut = false;  // the figures are of what is near route and flows; the rest is not loaded
  std::string profile;
  double warm_up_s = 0.0;
  double max_speed_mps = 0.0;
  double time_limit_s = 0.0;
  RouteFacts route;
  std::vector<FlowFacts> flows;
  int others = 0;  // vehicles of the scenario's own files, when the ego starts
  ScenarioCost cost;
  std::vector<std::string> warnings;  // it can be driven, but hardly as meant; each with its remedy
};

// For people, and as one JSON object.
std::string ReportText(const ScenarioReport& report);
std::string ReportJson(const ScenarioReport& report);

}  // namespace dadrl
