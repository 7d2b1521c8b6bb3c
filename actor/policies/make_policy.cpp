#include <filesystem>
#include <functional>
#include <map>
#include <utility>

#include "actor/policies/driving_policy.h"
#include "actor/policies/learned_policy.h"
#include "actor/policies/predictive_policy.h"
#include "actor/policies/scripted_policies.h"
#include "common/model/policy_file.h"

namespace dadrl {
namespace {

constexpr double kRdmSpeed = 15.0;  // m/s (paper's baseline)
constexpr double kCreepSpeed = 4.0;

using Maker = std::function<PolicySetup(const Config&, const PolicyOptions&)>;

const std::map<std::string, Maker>& ScriptedPolicies() {
  static const std::map<std::string, Maker> kPolicies = {
      {"idm",
       [](const Config& config, const PolicyOptions& options) {
         return PolicySetup{std::make_unique<SumoDriverPolicy>(),
                            {EgoDriver::kSumo, options.impatience},
                            config,
                            "idm, SUMO's own driver"};
       }},
      {"predictive",
       [](const Config& config, const PolicyOptions&) {
         return PolicySetup{std::make_unique<PredictivePolicy>(),
                            {},
                            config,
                            "predictive, rules that look four seconds ahead"};
       }},
      {"random",
       [](const Config& config, const PolicyOptions& options) {
         return PolicySetup{
             std::make_unique<RandomPolicy>(options.random_hold_steps), {}, config, "random commands"};
       }},
      {"rdm",
       [](const Config& config, const PolicyOptions&) {
         return PolicySetup{
             std::make_unique<ConstantSpeedPolicy>(kRdmSpeed, ConstantSpeedPolicy::Lane::kKeep),
             {},
             config,
             "rdm, which keeps its lane at 15 m/s and never yields"};
       }},
      {"slow",
       [](const Config& config, const PolicyOptions&) {
         return PolicySetup{
             std::make_unique<ConstantSpeedPolicy>(kCreepSpeed, ConstantSpeedPolicy::Lane::kRoute),
             {},
             config,
             "slow, which creeps at 4 m/s and never yields"};
       }},
  };
  return kPolicies;
}

std::string JoinedNames() {
  std::string names;
  for (const auto& [name, maker] : ScriptedPolicies()) names += (names.empty() ? "" : ", ") + name;
  return names;
}

Result<PolicySetup> LoadLearnedPolicy(const std::filesystem::path& path, const Config& config) {
  DADRL_ASSIGN_OR_RETURN(const PolicyFile file, LoadPolicy(path));
  PolicySetup setup;
  setup.description = fmt::format("a policy trained for {} updates", file.updates);
  setup.config = config;
  setup.config.observation = file.config.observation;
  setup.config.model = file.config.model;
  setup.config.task.decision_interval = file.config.task.decision_interval;
  setup.config.task.max_speed_mps = file.config.task.max_speed_mps;
  setup.config.algorithm.gamma = file.config.algorithm.gamma;
  DADRL_ASSIGN_OR_RETURN(auto model,
                         MakePolicyModel(DrivingShape::From(setup.config.observation), setup.config.model));
  DADRL_RETURN_IF_ERROR(CheckLayout(file.policy(), path, model->layout().hash(), model->layout().size()));
  DADRL_RETURN_IF_ERROR(model->Load(file.policy().parameters));
  setup.policy = std::make_unique<LearnedPolicy>(std::move(model));
  return setup;
}

}  // namespace

std::vector<std::string> ScriptedPolicyNames() {
  std::vector<std::string> names;
  for (const auto& [name, maker] : ScriptedPolicies()) names.push_back(name);
  return names;
}

Result<PolicySetup> MakePolicy(const std::string& name, const Config& config, const PolicyOptions& options) {
  if (options.random_hold_steps < 1) {
    return Fail(ErrorCode::kInvalidArgument, "a random action is held {} steps; it must be at least 1",
                options.random_hold_steps);
  }
  if (!(options.impatience >= 0.0 && options.impatience <= 1.0)) {
    return Fail(ErrorCode::kInvalidArgument, "impatience {} is not within [0, 1]", options.impatience);
  }
  const auto scripted = ScriptedPolicies().find(name);
  if (scripted != ScriptedPolicies().end()) return scripted->second(config, options);
  if (!std::filesystem::exists(name)) {
    return Fail(ErrorCode::kInvalidArgument, "policy '{}' is neither a file nor one of: {}", name,
                JoinedNames());
  }
  return LoadLearnedPolicy(name, config);
}

}  // namespace dadrl
