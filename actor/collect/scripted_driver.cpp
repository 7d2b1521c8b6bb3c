#include "actor/collect/scripted_driver.h"

#include <string>
#include <utility>

#include "actor/driving_environment.h"
#include "common/config/config_schema.h"

namespace dadrl {
namespace {

std::string NameOf(Config config) {
  for (const ConfigField& field : SchemaOf(config)) {
    if (field.key == "actor.policy") return FormatValue(field);
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<ScriptedDriver>> ScriptedDriver::Make(const Config& config) {
  if (config.actor.policy == ActorPolicy::kLearned) return nullptr;
  PolicyOptions options;
  options.random_hold_steps = config.task.decision_interval;
  DADRL_ASSIGN_OR_RETURN(PolicySetup setup, MakePolicy(NameOf(config), config, options));
  return std::unique_ptr<ScriptedDriver>(
      new ScriptedDriver(std::move(setup.policy), config.task.max_speed_mps));
}

Action ScriptedDriver::Act(const Environment& environment) {
  return ActionOf(policy_->Decide(*environment.driving()).command, max_speed_mps_);
}

}  // namespace dadrl
