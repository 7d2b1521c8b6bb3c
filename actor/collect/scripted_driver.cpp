#include "actor/collect/scripted_driver.h"

#include <string>
#include <utility>

#include "actor/driving_environment.h"
#include "common/config/config_schema.h"

namespace dadrl {
namespace {

// Of what a policy was trained on, against what this run drives.
Status CheckSame(const Config& trained, const Config& run) {
  Config before = trained;
  Config now = run;
  const std::vector<ConfigField> theirs = SchemaOf(before);
  const std::vector<ConfigField> ours = SchemaOf(now);
  for (size_t i = 0; i < ours.size(); ++i) {
    const std::string was = FormatValue(theirs[i]);
    const std::string is = FormatValue(ours[i]);
    const bool counts = ours[i].key.starts_with("observation.") || ours[i].key.starts_with("task.");
    if (was == is || !counts) continue;
    return Fail(ErrorCode::kInvalidArgument,
                "actor.policy: {} was trained with {}: {}, this run has {}; set it", run.actor.policy,
                ours[i].key, was, is);
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<ScriptedDriver>> ScriptedDriver::Make(const Config& config) {
  if (config.actor.policy == "learned") return nullptr;
  PolicyOptions options;
  options.random_hold_steps = config.task.decision_interval;
  DADRL_ASSIGN_OR_RETURN(PolicySetup setup, MakePolicy(config.actor.policy, config, options));
  DADRL_RETURN_IF_ERROR(CheckSame(setup.config, config));
  return std::unique_ptr<ScriptedDriver>(
      new ScriptedDriver(std::move(setup.policy), config.task.max_speed_mps));
}

Action ScriptedDriver::Act(const Environment& environment) {
  return ActionOf(policy_->Decide(*environment.driving()).command, max_speed_mps_);
}

}  // namespace dadrl
