#include "deploy/open_model/act.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/model/acting_policy.h"
#include "common/model/critic_values.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

void CopyOut(const Columns& batch, int index, Observation& observation) {
  const ColumnRows row(batch, index, 1);
  for (size_t i = 0; i < batch.columns(); ++i) {
    std::ranges::copy(row.floats(i), observation.floats(i).begin());
    std::ranges::copy(row.bits(i), observation.bits(i).begin());
  }
}

// Says which file the networks did not take.
tl::unexpected<Error> Named(const std::filesystem::path& path, const Status& status) {
  return Fail(status.error().code, "{}: {}", path.string(), status.error().message);
}

}  // namespace

Result<ActReport> ActOn(const Columns& observations, const PolicyFile& policy,
                        const std::filesystem::path& path) {
  const DrivingShape spec = DrivingShape::From(policy.config.observation);
  ActingPolicy acting(spec, policy.config.model);
  DADRL_RETURN_IF_ERROR(CheckLayout(policy.policy(), path, acting.layout_hash(), acting.parameter_count()));
  if (const Status loaded = acting.Load(policy.policy().parameters); !loaded) return Named(path, loaded);
  ActReport report;
  Observation observation(spec);
  std::vector<float> actions;
  for (int i = 0; i < observations.rows(); ++i) {
    CopyOut(observations, i, observation);
    report.action.push_back(acting.Act(observation, nullptr));
    report.mean.push_back(acting.last().mean);
    report.log_std.push_back(acting.last().log_std);
    report.attention.push_back(acting.last().attention);
    actions.insert(actions.end(), report.action.back().begin(), report.action.back().end());
  }
  const StoredNetwork* critic = policy.Find(kCriticNetwork);
  if (critic == nullptr) return report;
  CriticValues critics(spec, policy.config.model);
  DADRL_RETURN_IF_ERROR(CheckLayout(*critic, path, critics.layout().hash(), critics.layout().size()));
  if (const Status loaded = critics.Load(critic->parameters); !loaded) return Named(path, loaded);
  report.q1.resize(report.action.size());
  report.q2.resize(report.action.size());
  critics.Evaluate(observations, actions, report.q1, report.q2);
  return report;
}

std::string ActJson(const ActReport& report) {
  const auto values = [](const std::vector<float>& q) { return q.empty() ? Json() : Json(q); };
  const bool attends = !report.attention.front().empty();
  const Json json = {{"observations", report.action.size()},
                     {"mean", report.mean},
                     {"log_std", report.log_std},
                     {"action", report.action},
                     {"q1", values(report.q1)},
                     {"q2", values(report.q2)},
                     {"attention", attends ? Json(report.attention) : Json()}};
  return json.dump();
}

std::string ActTable(const ActReport& report) {
  std::string table = fmt::format("{:>6}  {:>16}  {:>16}  {:>14}  {:>16}  attention\n", "", "mean", "log std",
                                  "action", "q1, q2");
  const auto pair = [](float a, float b) { return fmt::format("{:7.3f} {:7.3f}", a, b); };
  for (size_t i = 0; i < report.action.size(); ++i) {
    const std::string q = report.q1.empty() ? "none" : pair(report.q1[i], report.q2[i]);
    table += fmt::format("{:>6}  {:>16}  {:>16}  {:>14}  {:>16}  {:.2f}\n", i,
                         pair(report.mean[i][0], report.mean[i][1]),
                         pair(report.log_std[i][0], report.log_std[i][1]),
                         fmt::format("{:.3f} {:.3f}", report.action[i][0], report.action[i][1]), q,
                         fmt::join(report.attention[i], " "));
  }
  return table;
}

}  // namespace dadrl
