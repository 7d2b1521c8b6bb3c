// What the networks beside the policy say of observations and actions: for showing and comparing them, not
// for training.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/config/config.h"
#include "common/nn/param_layout.h"
#include "common/step/driving_shape.h"
#include "common/util/result.h"

namespace dadrl {

// Not thread safe.
class ValueModel {
 public:
  virtual ~ValueModel() = default;

  // Of the flat parameter vector, as policy files hold it.
  virtual const nn::ParamLayout& layout() const = 0;

  // Copies the parameters. kInvalidArgument when the length is wrong, kCorrupt when one is not finite.
  virtual Status Load(std::span<const float> parameters) = 0;

  struct Values {
    std::string name;           // "q1"
    std::vector<float> values;  // [rows]
  };
  // Of `observations` and their `actions` [rows, 2]; the same names in the same order each time. Requires a
  // Load.
  virtual std::vector<Values> Evaluate(const Columns& observations, std::span<const float> actions) = 0;
};

// That of the network that policy files hold under this name, for the observations of these steps.
// kInvalidArgument when there is none, or a column that it reads is missing.
Result<std::unique_ptr<ValueModel>> MakeValueModel(std::string_view network, const StepSpec& spec,
                                                   const ModelConfig& model);

}  // namespace dadrl
