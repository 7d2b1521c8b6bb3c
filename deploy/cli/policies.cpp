#include <cstdio>
#include <memory>

#include "deploy/cli/command.h"
#include "deploy/local/shipped_policies.h"

namespace dadrl {
namespace {

using Json = nlohmann::ordered_json;

// The value at `path` ("/training/updates") as text; "?" when the record does not say.
std::string At(const Json& record, const char* path) {
  const Json::json_pointer pointer(path);
  if (!record.contains(pointer)) return "?";
  const Json& value = record[pointer];
  return value.is_string() ? value.get<std::string>() : value.dump();
}

double NumberAt(const Json& record, const char* path) {
  const Json::json_pointer pointer(path);
  return record.contains(pointer) && record[pointer].is_number() ? record[pointer].get<double>() : 0.0;
}

void PrintTable(const std::vector<ShippedPolicy>& policies) {
  constexpr std::string_view kRow = "{:<32} {:<14} {:>8} {:>20} {:>11} {:>9} {:>8}  {}\n";
  fmt::print(kRow, "policy", "trained on", "episodes", "success %", "collision %", "updates", "minutes",
             "commit");
  for (const ShippedPolicy& policy : policies) {
    const Json& record = policy.record;
    const std::string success =
        fmt::format("{:.1f} [{:.1f}, {:.1f}]", 100 * NumberAt(record, "/evaluation/success"),
                    100 * NumberAt(record, "/evaluation/success_ci95/0"),
                    100 * NumberAt(record, "/evaluation/success_ci95/1"));
    fmt::print(kRow, "pretrained:" + policy.name, At(record, "/scenario"), At(record, "/evaluation/episodes"),
               success, fmt::format("{:.1f}", 100 * NumberAt(record, "/evaluation/collision")),
               At(record, "/training/updates"),
               fmt::format("{:.1f}", NumberAt(record, "/training/training_s") / 60),
               At(record, "/training/commit"));
  }
}

void PrintJson(const std::vector<ShippedPolicy>& policies) {
  Json rows = Json::array();
  for (const ShippedPolicy& policy : policies) {
    rows.push_back({{"name", policy.name}, {"file", policy.file.string()}, {"record", policy.record}});
  }
  const Json object = {{"policies", std::move(rows)}};
  fmt::print("{}\n", object.dump(-1, ' ', false, Json::error_handler_t::replace));
}

Result<int> RunPolicies(bool json) {
  const std::vector<ShippedPolicy> policies = ShippedPolicies();
  if (json) {
    PrintJson(policies);
  } else if (policies.empty()) {
    fmt::print(stderr, "no policy ships in {}\n", PolicyFolder().string());
  } else {
    PrintTable(policies);
  }
  return 0;
}

}  // namespace

Command MakePoliciesCommand(CLI::App& dadrl) {
  auto json = std::make_shared<bool>(false);
  CLI::App* app = dadrl.add_subcommand("policies", "List the trained policies that ship, with their results");
  app->add_flag("--json", *json, "One JSON object on standard output: everything known of each");
  return {app, [json] { return RunPolicies(*json); }};
}

}  // namespace dadrl
