#include "deploy/cli/driver.h"

#include <cstdio>
#include <optional>
#include <span>
#include <utility>

#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "common/io/unnamed_file.h"
#include "common/model/policy_file.h"
#include "deploy/local/executables.h"
#include "deploy/local/scenario_gate.h"
#include "deploy/local/shipped_policies.h"

namespace dadrl {

namespace {

// The scenario a policy file was trained on; nothing for a word that is no file: the name of a scripted
// driver.
Result<std::optional<std::string>> TrainedScenario(const std::string& policy) {
  std::error_code error;
  const bool looks_like_file = policy.find_first_of("/.") != std::string::npos;
  if (!looks_like_file && !std::filesystem::exists(policy, error)) return std::nullopt;
  DADRL_ASSIGN_OR_RETURN(const PolicyFile file, LoadPolicy(policy));
  return file.config.scenario;
}

}  // namespace

void DriverOptions::AddTo(CLI::App& app, const std::string& scenario_help) {
  app.add_option("--policy", policy,
                 "Policy file, pretrained:NAME (`dadrl policies` lists them), or a scripted driver: random, "
                 "rdm, slow, idm, predictive")
      ->required();
  app.add_option("--scenario", scenario, scenario_help);
}

Result<Driver> DriverOptions::Resolve() const {
  DADRL_ASSIGN_OR_RETURN(Config effective, config.ApplyToPreset());
  DADRL_ASSIGN_OR_RETURN(std::string resolved, ResolvePolicy(policy));
  DADRL_ASSIGN_OR_RETURN(const std::optional<std::string> trained, TrainedScenario(resolved));
  if (scenario.empty() && !trained) {
    return Fail(ErrorCode::kInvalidArgument, "--scenario is needed with --policy {}; there are: {}", policy,
                fmt::join(ScenarioNames(), ", "));
  }
  effective.scenario = scenario.empty() ? *trained : scenario;
  DADRL_RETURN_IF_ERROR(CheckScenario(effective.scenario));
  DADRL_RETURN_IF_ERROR(Validate(effective));
  DADRL_ASSIGN_OR_RETURN(std::filesystem::path program, FindExecutable("dadrl-actor"));
  const std::string yaml = ToYaml(effective, false);
  DADRL_ASSIGN_OR_RETURN(SharedFile shared,
                         SharedFile::Create("config.yaml", std::as_bytes(std::span(yaml))));
  return Driver{std::move(program), std::move(resolved), std::move(effective), std::move(shared)};
}

Status RequireDrivable(const Config& config, std::string_view command, SignalWatcher* signals) {
  DADRL_ASSIGN_OR_RETURN(const std::vector<std::string> warnings, CheckDrivable(config, signals));
  for (const std::string& warning : warnings) fmt::print(stderr, "dadrl {}: {}\n", command, warning);
  return {};
}

}  // namespace dadrl
