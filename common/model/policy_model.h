// What acts: the one interface of a policy, for whoever drives with it, shows what it thinks, or saves it.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/nn/param_layout.h"
#include "common/step/driving_shape.h"
#include "common/util/random.h"
#include "common/util/result.h"

namespace dadrl {

// One observation at a time, on one core. Not thread safe; owns all its memory, allocates nothing in Act.
class PolicyModel {
 public:
  virtual ~PolicyModel() = default;

  // Of the flat parameter vector, which broadcasts carry and policy files hold as kPolicyNetwork: one of
  // another hash or length is refused.
  virtual const nn::ParamLayout& layout() const = 0;

  // Copies the parameters. kInvalidArgument when the length is wrong, kCorrupt when one is not finite; those
  // before then stay. May come in the middle of an episode, which is not forgotten by it.
  virtual Status Load(std::span<const float> parameters) = 0;

  // Forgets what was remembered of an episode: once before the first Act of each. In an actor that drives at
  // random until it has parameters, the first Act may come later than the episode's first decision.
  virtual void BeginEpisode() {}

  // An action sampled with noise from `random`, or the likeliest when `random` is null. Requires a Load; the
  // observation must be of the model's configuration.
  virtual Action Act(const Observation& observation, Random* random) = 0;

  // Of the last Act.
  struct Details {
    struct Numbers {
      std::string_view name;
      std::span<const float> values;
    };
    std::vector<float> attention;  // [vehicles], sums to at most 1; empty where the model attends to none
    std::optional<float> value;    // of the observation, where the model estimates it: the return to come
    std::optional<float>
        log_probability;           // density of the sampled action in (-1, 1)^2, nats; none of the likeliest
    std::vector<Numbers> numbers;  // what else it says, the same names in the same order each time

    // Numbers, or the log-probability. Empty when there are none of that name.
    std::span<const float> Find(std::string_view name) const;
  };
  // Valid until the next Act.
  virtual const Details& last() const = 0;
};

// The names that `model.policy` may have.
std::vector<std::string> PolicyModelNames();

// kInvalidArgument, with the nearest name, when `model.policy` is none of them.
Status CheckPolicyModel(const ModelConfig& model);

// The one of `model.policy`, without parameters, for the observations of these steps. kInvalidArgument as
// CheckPolicyModel, or when a column that it reads is missing.
Result<std::unique_ptr<PolicyModel>> MakePolicyModel(const StepSpec& spec, const ModelConfig& model);

}  // namespace dadrl
