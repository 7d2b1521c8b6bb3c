#include <algorithm>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "deploy/cli/command.h"
#include "deploy/local/machine_checks.h"

namespace dadrl {
namespace {

struct DoctorOptions {
  ConfigOptions config;
  bool json = false;
};

const char* StateName(CheckState state) {
  switch (state) {
    case CheckState::kGood:
      return "good";
    case CheckState::kWarning:
      return "warning";
    case CheckState::kBroken:
      return "broken";
  }
  return "";
}

void PrintText(const std::vector<MachineCheck>& checks) {
  for (const MachineCheck& check : checks) {
    fmt::print("{:<8} {:<14} {}\n", StateName(check.state), check.name, check.detail);
    if (!check.remedy.empty()) fmt::print("{:<8} {:<14} mend: {}\n", "", "", check.remedy);
  }
}

void PrintJson(const std::vector<MachineCheck>& checks, bool healthy) {
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (const MachineCheck& check : checks) {
    rows.push_back({{"name", check.name},
                    {"state", StateName(check.state)},
                    {"detail", check.detail},
                    {"remedy", check.remedy}});
  }
  const nlohmann::ordered_json object = {{"healthy", healthy}, {"checks", rows}};
  fmt::print("{}\n", object.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

Result<int> RunDoctor(const DoctorOptions& options) {
  DADRL_ASSIGN_OR_RETURN(const Config config, options.config.Apply(Config{}));
  const std::vector<MachineCheck> checks = CheckMachine(config);
  const bool healthy = std::none_of(checks.begin(), checks.end(), [](const MachineCheck& check) {
    return check.state == CheckState::kBroken;
  });
  if (options.json) {
    PrintJson(checks, healthy);
  } else {
    PrintText(checks);
  }
  return healthy ? 0 : 1;
}

}  // namespace

Command MakeDoctorCommand(CLI::App& dadrl) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* app = dadrl.add_subcommand("doctor", "Check this machine and say how to mend what is wrong");
  app->add_flag("--json", options->json, "One JSON object on standard output");
  options->config.AddTo(*app);
  return {app, [options] { return RunDoctor(*options); }};
}

}  // namespace dadrl
