#include "common/config/config_yaml.h"
#include "common/model/policy_model.h"
#include "deploy/cli/command.h"
#include "deploy/local/algorithm_presets.h"

namespace dadrl {

void ConfigOptions::AddTo(CLI::App& app) {
  app.add_option("--config", file, "YAML file with some or all keys (`dadrl config --explain` shows them)")
      ->type_name("FILE");
  app.add_option("--set", sets,
                 "One key, e.g. --set algorithm.gamma=0.99; may be repeated; wins over --config")
      ->type_name("KEY=VALUE")
      ->allow_extra_args(false);
}

Result<Config> ConfigOptions::Apply(Config base) const {
  if (!file.empty()) DADRL_RETURN_IF_ERROR(LoadYaml(file, base));
  for (const std::string& assignment : sets) DADRL_RETURN_IF_ERROR(ApplyOverride(assignment, base));
  DADRL_RETURN_IF_ERROR(CheckPolicyModel(base.model));
  return base;
}

Result<Config> ConfigOptions::ApplyToPreset() const {
  DADRL_ASSIGN_OR_RETURN(const Config named, Apply(Config{}));
  DADRL_ASSIGN_OR_RETURN(Config preset, LoadPreset(named.algorithm.name));
  return Apply(std::move(preset));
}

}  // namespace dadrl
