#include "deploy/open_model/act.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/model/policy_model.h"

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

// Says which file holds the network.
tl::unexpected<Error> Named(const std::filesystem::path& path, const Error& error) {
  return Fail(error.code, "{}: {}", path.string(), error.message);
}

void Append(const PolicyModel::Details& details, ActReport& report) {
  report.numbers.resize(details.numbers.size());
  for (size_t n = 0; n < details.numbers.size(); ++n) {
    report.numbers[n].name = details.numbers[n].name;
    report.numbers[n].rows.emplace_back(details.numbers[n].values.begin(), details.numbers[n].values.end());
  }
  if (details.value) {
    report.values.resize(1, {"value", {}});
    report.values.front().values.push_back(*details.value);
  }
  report.attention.push_back(details.attention);
}

Status AskPolicy(const Columns& observations, const PolicyFile& file, const std::filesystem::path& path,
                 ActReport& report) {
  const DrivingShape spec = DrivingShape::From(file.config.observation);
  const auto policy = MakePolicyModel(spec, file.config.model);
  if (!policy) return Named(path, policy.error());
  const nn::ParamLayout& layout = (*policy)->layout();
  DADRL_RETURN_IF_ERROR(CheckLayout(file.policy(), path, layout.hash(), layout.size()));
  if (const Status loaded = (*policy)->Load(file.policy().parameters); !loaded) {
    return Named(path, loaded.error());
  }
  (*policy)->BeginEpisode();
  Observation observation(spec);
  for (int i = 0; i < observations.rows(); ++i) {
    CopyOut(observations, i, observation);
    report.action.push_back((*policy)->Act(observation, nullptr));
    Append((*policy)->last(), report);
  }
  return {};
}

Status AskNetwork(const Columns& observations, const StoredNetwork& network, const PolicyFile& file,
                  const std::filesystem::path& path, ActReport& report) {
  const auto model =
      MakeValueModel(network.name, DrivingShape::From(file.config.observation), file.config.model);
  if (!model) return Named(path, model.error());
  const nn::ParamLayout& layout = (*model)->layout();
  DADRL_RETURN_IF_ERROR(CheckLayout(network, path, layout.hash(), layout.size()));
  if (const Status loaded = (*model)->Load(network.parameters); !loaded) return Named(path, loaded.error());
  std::vector<float> actions;
  for (const Action& action : report.action) actions.insert(actions.end(), action.begin(), action.end());
  std::ranges::move((*model)->Evaluate(observations, actions), std::back_inserter(report.values));
  return {};
}

}  // namespace

Result<ActReport> ActOn(const Columns& observations, const PolicyFile& policy,
                        const std::filesystem::path& path) {
  ActReport report;
  DADRL_RETURN_IF_ERROR(AskPolicy(observations, policy, path, report));
  for (const StoredNetwork& network : policy.networks) {
    if (network.name == kPolicyNetwork) continue;
    DADRL_RETURN_IF_ERROR(AskNetwork(observations, network, policy, path, report));
  }
  return report;
}

std::string ActJson(const ActReport& report) {
  Json json = {{"observations", report.action.size()}};
  for (const ActReport::Numbers& numbers : report.numbers) json[numbers.name] = numbers.rows;
  json["action"] = report.action;
  for (const ValueModel::Values& values : report.values) json[values.name] = values.values;
  const bool attends = !report.attention.front().empty();
  json["attention"] = attends ? Json(report.attention) : Json();
  return json.dump();
}

std::string ActTable(const ActReport& report) {
  const auto joined = [](std::span<const float> row) { return fmt::format("{:7.3f}", fmt::join(row, " ")); };
  const auto column = [](size_t numbers) { return 8 * numbers - 1; };
  std::string table = fmt::format("{:>6}", "");
  for (const ActReport::Numbers& numbers : report.numbers) {
    table += fmt::format("  {:>{}}", numbers.name, column(numbers.rows.front().size()));
  }
  table += fmt::format("  {:>{}}", "action", column(kActionSize));
  for (const ValueModel::Values& values : report.values)
    table += fmt::format("  {:>{}}", values.name, column(1));
  table += "  attention\n";
  for (size_t i = 0; i < report.action.size(); ++i) {
    table += fmt::format("{:>6}", i);
    for (const ActReport::Numbers& numbers : report.numbers) table += "  " + joined(numbers.rows[i]);
    table += "  " + joined(report.action[i]);
    for (const ValueModel::Values& values : report.values)
      table += fmt::format("  {:7.3f}", values.values[i]);
    table += fmt::format("  {:.2f}\n", fmt::join(report.attention[i], " "));
  }
  return table;
}

}  // namespace dadrl
