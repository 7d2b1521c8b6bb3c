// The networks of the system and their flat parameter layouts.
#pragma once

#include <span>
#include <string_view>

#include "common/model/encoder.h"
#include "common/model/mlp.h"
#include "common/nn/adam.h"
#include "common/util/result.h"

namespace dadrl {

// Observation to the policy's mean and log standard deviation. Actors run it, broadcasts and policy files
// hold its parameters: "encoder.*", then "policy.*".
struct PolicyNetwork {
  PolicyNetwork(const DrivingShape& spec, const ModelConfig& model);

  nn::ParamLayout layout;
  Encoder encoder;
  Mlp head;  // features -> [mean 2, log_std 2]
  nn::Range encoder_range;
  nn::Range head_range;
};

// Observation to one value, the return to come: "encoder.*", then "value.*".
struct ValueNetwork {
  ValueNetwork(const DrivingShape& spec, const ModelConfig& model);

  nn::ParamLayout layout;
  Encoder encoder;
  Mlp head;  // features -> 1
  nn::Range encoder_range;
};

// Observation and action to two values: "encoder.*", "critic1.*", "critic2.*". Targets have the same layout.
struct CriticNetwork {
  CriticNetwork(const DrivingShape& spec, const ModelConfig& model);

  nn::ParamLayout layout;
  Encoder encoder;
  Mlp critic1;  // [features, action 2] -> 1
  Mlp critic2;
  nn::Range encoder_range;
  nn::Range head_range;
};

// Whether `parameters`, of the network called `what` ("policy"), may be loaded: kInvalidArgument when there
// are more or fewer than `layout` has, kCorrupt when one is not finite.
Status CheckParameters(std::string_view what, const nn::ParamLayout& layout,
                       std::span<const float> parameters);

}  // namespace dadrl
