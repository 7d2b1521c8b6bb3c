// results.json: what a run has come to, over all its sessions.
#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/local/episode_log.h"
#include "deploy/local/lost_time.h"
#include "deploy/local/training_curve.h"
#include "proto/evaluation/report.h"

namespace dadrl {

// Where in the training an evaluation was made.
struct EvaluatedAt {
  double elapsed_s = 0.0;
  uint64_t env_steps = 0;
  uint64_t updates = 0;
  uint32_t policy_version = 0;
};

// Not thread safe.
class RunResults {
 public:
  // Reads the results of earlier sessions when there are any; a damaged file is set aside as *.corrupt.
  static RunResults Load(const std::filesystem::path& path, const Config& config);

  // Seconds of training in earlier sessions.
  double earlier_s() const { return earlier_s_; }

  void AddEvaluation(const EvaluatedAt& at, const EvaluationReport& report);
  void SetFinal(const EvaluatedAt& at, const EvaluationReport& report);
  // `state`: "running", "finished", "interrupted", "held_up", "failed".
  void Update(const std::string& state, double session_s, const TrainedSoFar& trained,
              const EpisodeLog& episodes);
  // What faults took in this session, added to the earlier ones.
  void SetLost(const LostTime& lost);
  // What results.json holds.
  std::string Text() const { return json_.dump(2) + "\n"; }

 private:
  RunResults() = default;

  double earlier_s_ = 0.0;
  std::map<std::string, double> earlier_lost_s_;  // by fault
  nlohmann::ordered_json json_;
};

// "success 91.0 % [78.3, 97.1], collision 7.5 %, off-road 0.0 %, stagnation 1.5 % of 40 episodes".
std::string ReportLine(const EvaluationReport& report);

// The newest evaluation in a results.json, as ReportLine shows it; empty when there is none.
std::string LastEvaluation(const std::filesystem::path& results);

}  // namespace dadrl
