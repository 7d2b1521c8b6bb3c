#include "common/model/policy_model.h"

#include <algorithm>
#include <array>

#include "common/config/config_schema.h"
#include "common/model/decision_transformer_policy.h"
#include "common/model/squashed_gaussian_policy.h"
#include "common/util/shown.h"

namespace dadrl {
namespace {

struct Entry {
  std::string_view name;
  Result<std::unique_ptr<PolicyModel>> (*make)(const StepSpec&, const ModelConfig&);
};

constexpr std::array kPolicyModels = {Entry{"decision_transformer", MakeDecisionTransformerPolicy},
                                      Entry{"squashed_gaussian", MakeSquashedGaussianPolicy}};

const Entry* FindEntry(std::string_view name) {
  const auto* found = std::ranges::find(kPolicyModels, name, &Entry::name);
  return found == kPolicyModels.end() ? nullptr : found;
}

}  // namespace

std::span<const float> PolicyModel::Details::Find(std::string_view name) const {
  if (name == "log_probability" && log_probability) return {&*log_probability, 1};
  const auto found = std::ranges::find(numbers, name, &Numbers::name);
  return found == numbers.end() ? std::span<const float>() : found->values;
}

std::vector<std::string> PolicyModelNames() {
  std::vector<std::string> names;
  for (const Entry& entry : kPolicyModels) names.emplace_back(entry.name);
  return names;
}

Status CheckPolicyModel(const ModelConfig& model) {
  if (FindEntry(model.policy) != nullptr) return {};
  const std::vector<std::string> names = PolicyModelNames();
  return Fail(ErrorCode::kInvalidArgument, "model.policy: '{}' is unknown; did you mean {}? There are: {}",
              Shown(model.policy), NearestName(model.policy, names), fmt::join(names, ", "));
}

Result<std::unique_ptr<PolicyModel>> MakePolicyModel(const StepSpec& spec, const ModelConfig& model) {
  DADRL_RETURN_IF_ERROR(CheckPolicyModel(model));
  return FindEntry(model.policy)->make(spec, model);
}

}  // namespace dadrl
