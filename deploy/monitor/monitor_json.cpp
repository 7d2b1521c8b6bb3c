#include "deploy/monitor/monitor_json.h"

#include <algorithm>
#include <cmath>

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

// Metrics come from other processes; JSON has no NaN.
double Finite(double value) { return std::isfinite(value) ? value : 0.0; }

int64_t Whole(double value) { return std::llround(Finite(value)); }

Json MeanMaxJson(const MeanMax& value) { return {{"mean", Finite(value.mean)}, {"max", Finite(value.max)}}; }

Json ProcessJson(const ProcessRow& row) {
  Json shares = Json::object();
  for (size_t i = 0; i < row.share.size(); ++i) {
    if (row.share[i] > 0.0) shares[std::string(ActivityName(row.share.At(i)))] = Finite(row.share[i]);
  }
  Json metrics = Json::object();
  for (size_t i = 0; i < row.metrics.size(); ++i) {
    if (row.metrics[i] != 0.0) metrics[std::string(MetricName(row.metrics.At(i)))] = Finite(row.metrics[i]);
  }
  for (const NamedScalar& scalar : row.scalars) metrics.emplace(scalar.name, Finite(scalar.value));
  return {{"name", row.name},
          {"pid", row.pid},
          {"stale", row.stale},
          {"silent_s", Finite(row.silent_s)},
          {"uptime_s", Finite(row.uptime_s)},
          {"state", row.state},
          {"trouble", row.trouble},
          {"restarts", row.restarts},
          {"hangs", row.hangs},
          {"per_s", Finite(row.steps_per_s)},
          {"time", shares},
          {"metrics", metrics}};
}

Json FaultsJson(const std::vector<ProcessFault>& faults) {
  Json rows = Json::array();
  for (const ProcessFault& fault : faults) {
    rows.push_back({{"process", fault.process},
                    {"kind", FaultName(fault.fault.kind)},
                    {"text", fault.fault.text},
                    {"since_s", Finite(fault.fault.since_s)}});
  }
  return rows;
}

// Under the names that the algorithm declares; "critic_loss" is "critic" here, unless that is another scalar.
Json LossesJson(const std::vector<NamedScalar>& scalars) {
  constexpr std::string_view kLoss = "_loss";
  Json json = Json::object();
  for (const NamedScalar& scalar : scalars) {
    std::string key = scalar.name;
    if (key.ends_with(kLoss)) key.resize(key.size() - kLoss.size());
    const bool taken = key.empty() || std::ranges::find(scalars, key, &NamedScalar::name) != scalars.end();
    json[taken ? scalar.name : key] = Finite(scalar.value);
  }
  return json;
}

Json ScenariosJson(const std::map<std::string, RecentRate>& scenarios) {
  Json json = Json::object();
  for (const auto& [name, rate] : scenarios) {
    json[name] = {{"count", rate.episodes}, {"success", Finite(rate.success)}};
  }
  return json;
}

}  // namespace

Json MonitorJson(const ClusterSummary& summary, const std::string& bottleneck) {
  Json waits = Json::array();
  for (const Wait& wait : summary.waits) {
    waits.push_back({{"who", wait.who},
                     {"for", wait.for_what},
                     {"fraction", Finite(wait.fraction)},
                     {"count", wait.spent.count},
                     {"seconds", Finite(wait.spent.seconds)}});
  }
  Json processes = Json::array();
  for (const ProcessRow& row : summary.processes) processes.push_back(ProcessJson(row));
  return {{"env_steps_per_s", Finite(summary.env_steps_per_s)},
          {"inserted_frames_per_s", Finite(summary.inserted_frames_per_s)},
          {"sampled_transitions_per_s", Finite(summary.sampled_transitions_per_s)},
          {"mb_per_s", Finite(summary.inserted_mb_per_s + summary.sampled_mb_per_s)},
          {"inserted_mb_per_s", Finite(summary.inserted_mb_per_s)},
          {"sampled_mb_per_s", Finite(summary.sampled_mb_per_s)},
          {"updates_per_s", Finite(summary.updates_per_s)},
          {"updates", Whole(summary.updates)},
          {"learner_cpu_s", Finite(summary.learner_cpu_s)},
          {"weights_version", Whole(summary.weights_version)},
          {"replay_frames", Whole(summary.replay_frames)},
          {"replay_bytes", Whole(summary.replay_bytes)},
          {"snapshot_bytes", Whole(summary.snapshot_bytes)},
          {"staleness_versions", MeanMaxJson(summary.staleness_versions)},
          {"staleness_s", MeanMaxJson(summary.staleness_s)},
          {"waits", waits},
          {"rejected", summary.rejected},
          {"faults", FaultsJson(summary.faults)},
          {"bottleneck", bottleneck},
          {"losses", LossesJson(summary.scalars)},
          {"recent_episodes",
           {{"count", summary.recent_episodes},
            {"success", Finite(summary.recent_success)},
            {"collision", Finite(summary.recent_collision)},
            {"off_road", Finite(summary.recent_off_road)},
            {"stagnation", Finite(summary.recent_stagnation)},
            {"mean_return", Finite(summary.recent_return)},
            {"scenarios", ScenariosJson(summary.recent_scenarios)}}},
          {"actors_alive", summary.actors_alive},
          {"processes", processes}};
}

}  // namespace dadrl
