#include "deploy/local/run_results.h"

#include <system_error>
#include <utility>

#include "common/io/json_text.h"
#include "common/io/read_file.h"
#include "deploy/local/build_info.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

constexpr uint64_t kMaxBytes = uint64_t{64} << 20;

// 0 for what is no count, and for what no run has come to.
double Number(const Json& json, const char* key) {
  constexpr double kMost = 1e15;
  return JsonFields(json).Number(key, 0.0, kMost);
}

Json EvaluationJson(const EvaluatedAt& at, const EvaluationReport& report) {
  Json json = {{"elapsed_s", at.elapsed_s},
               {"env_steps", at.env_steps},
               {"updates", at.updates},
               {"policy_version", at.policy_version}};
  json.update(Json::parse(ReportJson(report)));
  return json;
}

}  // namespace

RunResults RunResults::Load(const std::filesystem::path& path, const Config& config) {
  RunResults results;
  if (const auto text = ReadTextFile(path, kMaxBytes)) {
    results.json_ = ParseJson(*text, path.string()).value_or(Json());
    if (!results.json_.is_object()) {
      std::error_code ignored;
      std::filesystem::rename(path, path.string() + ".corrupt", ignored);
      results.json_ = Json::object();
    }
  } else {
    results.json_ = Json::object();
  }
  Json& json = results.json_;
  results.earlier_s_ = Number(json, "training_s");
  if (const auto lost = json.find("lost_s"); lost != json.end() && lost->is_object()) {
    for (const auto& [fault, seconds] : lost->items()) {
      if (seconds.is_number()) results.earlier_lost_s_[fault] = Number(*lost, fault.c_str());
    }
  }
  json["scenario"] = config.scenario;
  json["seed"] = config.seed;
  json["commit"] = BuildCommit();
  json["machine"] = MachineName();
  if (!json["evaluations"].is_array()) json["evaluations"] = Json::array();
  return results;
}

void RunResults::AddEvaluation(const EvaluatedAt& at, const EvaluationReport& report) {
  json_["evaluations"].push_back(EvaluationJson(at, report));
}

void RunResults::SetFinal(const EvaluatedAt& at, const EvaluationReport& report) {
  json_["final"] = EvaluationJson(at, report);
}

void RunResults::Update(const std::string& state, double session_s, const TrainedSoFar& trained,
                        const EpisodeLog& episodes) {
  json_["state"] = state;
  json_["training_s"] = earlier_s_ + session_s;
  if (trained.updates > 0) json_["updates"] = trained.updates;
  if (trained.cpu_s > 0.0) json_["learner_cpu_s"] = trained.cpu_s;
  if (trained.weights_version > 0) json_["weights_version"] = trained.weights_version;
  json_["env_steps"] = episodes.env_steps();
  json_["training_episodes"] = episodes.episodes();
}

void RunResults::SetLost(const LostTime& lost) {
  std::map<std::string, double> seconds = earlier_lost_s_;
  for (const auto& [fault, duration] : lost.by_fault()) seconds[fault] += ToSeconds(duration);
  json_["lost_s"] = Json::object();
  for (const auto& [fault, s] : seconds) json_["lost_s"][fault] = s;
}

std::string LastEvaluation(const std::filesystem::path& results) {
  const auto text = ReadTextFile(results, kMaxBytes);
  const Json json = text ? ParseJson(*text, results.string()).value_or(Json()) : Json();
  if (!json.is_object()) return "";
  const Json* last = json.contains("final") ? &json["final"] : nullptr;
  if (last == nullptr && json.contains("evaluations") && json["evaluations"].is_array() &&
      !json["evaluations"].empty()) {
    last = &json["evaluations"].back();
  }
  if (last == nullptr || !last->is_object()) return "";
  return fmt::format("{:.0f} updates: success {:.1f} %, collision {:.1f} % of {:.0f} unseen episodes",
                     Number(*last, "updates"), 100 * Number(*last, "success"),
                     100 * Number(*last, "collision"), Number(*last, "episodes"));
}

std::string ReportLine(const EvaluationReport& report) {
  const EvaluationFigures& all = report.all;
  return fmt::format(
      "success {:.1f} % [{:.1f}, {:.1f}], collision {:.1f} %, off-road {:.1f} %, stagnation {:.1f} % "
      "of {} unseen episodes",
      100 * all.success, 100 * all.success_ci95.first, 100 * all.success_ci95.second, 100 * all.collision,
      100 * all.off_road, 100 * all.stagnation, all.episodes);
}

}  // namespace dadrl
