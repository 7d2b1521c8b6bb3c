#include "common/model/squashed_gaussian_policy.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "common/model/acting_stae.h"
#include "common/model/networks.h"
#include "common/nn/squashed_gaussian.h"

namespace dadrl {
namespace {

// The packed networks and their scratch, laid out in an arena.
struct Stack {
  Stack(nn::Arena& arena, const PolicyNetwork& network, const ModelConfig& model)
      : hidden1(arena, network.encoder.features(), model.hidden),
        hidden2(arena, model.hidden, model.hidden),
        output(arena, model.hidden, 2 * kActionSize),
        pooled(arena.Allocate(nn::kConvFeatures)),
        features(arena.Allocate(network.encoder.features())),
        layer1(arena.Allocate(hidden1.padded)),
        layer2(arena.Allocate(hidden2.padded)),
        result(arena.Allocate(output.padded)) {
    if (network.encoder.stae) stae.emplace(arena, network.encoder.spec);
    if (network.encoder.scene) scene.emplace(arena, network.encoder.scene->graph, 1, false);
    if (network.encoder.context)
      context_output = DenseRow(arena, nn::kConvFeatures, ContextEncoder::kFeatures);
  }

  std::optional<ActingStae> stae;
  std::optional<nn::Tape> scene;
  DenseRow context_output, hidden1, hidden2, output;
  float* pooled;
  float* features;
  float* layer1;
  float* layer2;
  float* result;
};

nn::Arena ArenaFor(const PolicyNetwork& network, const ModelConfig& model) {
  nn::Arena measure;
  const Stack measured(measure, network, model);
  return nn::Arena(measure.used());
}

class SquashedGaussianPolicy final : public PolicyModel {
 public:
  SquashedGaussianPolicy(const DrivingShape& shape, const ModelConfig& model);
  SquashedGaussianPolicy(const SquashedGaussianPolicy&) = delete;  // details_ points into it
  SquashedGaussianPolicy& operator=(const SquashedGaussianPolicy&) = delete;

  const nn::ParamLayout& layout() const override { return network_.layout; }
  Status Load(std::span<const float> parameters) override;
  Action Act(const Observation& observation, Random* random) override;
  const Details& last() const override { return details_; }

 private:
  void Pack();
  void Encode(const Observation& observation);
  Action Sample(Random& random);

  const nn::GaussianLimits limits_;
  const PolicyNetwork network_;
  const nn::LaneKernels& kernels_;
  nn::Arena arena_;
  Stack stack_;
  nn::SingleImageConvStack conv_;
  nn::FloatBuffer parameters_;
  Action mean_{};
  Action log_std_{};
  Details details_;
};

SquashedGaussianPolicy::SquashedGaussianPolicy(const DrivingShape& shape, const ModelConfig& model)
    : limits_{model.log_std_min, model.log_std_max},
      network_(shape, model),
      kernels_(nn::LaneKernelsFor(ActiveIsa())),
      arena_(ArenaFor(network_, model)),
      stack_(arena_, network_, model),
      parameters_(network_.layout.size()) {
  if (network_.encoder.stae || network_.encoder.scene)
    details_.attention.resize(static_cast<size_t>(shape.vehicles));
  details_.numbers = {{"mean", mean_}, {"log_std", log_std_}};
}

void SquashedGaussianPolicy::Pack() {
  const float* p = parameters_.data();
  const auto pack = [&](DenseRow& row, const nn::Linear& layer) {
    row.Pack(p + layer.weight, p + layer.bias);
  };
  if (stack_.stae) stack_.stae->Pack(*network_.encoder.stae, p);
  if (network_.encoder.context) {
    conv_.Pack(network_.encoder.context->ConvParams(p));
    pack(stack_.context_output, network_.encoder.context->output);
  }
  pack(stack_.hidden1, network_.head.hidden1);
  pack(stack_.hidden2, network_.head.hidden2);
  pack(stack_.output, network_.head.output);
}

void SquashedGaussianPolicy::Encode(const Observation& observation) {
  const DrivingShape& shape = network_.encoder.spec;
  if (stack_.stae) {
    stack_.stae->Forward(kernels_, observation, stack_.features, details_.attention);
  } else if (stack_.scene) {
    const SceneEncoder& scene = *network_.encoder.scene;
    PackScene(scene, observation, 0, *stack_.scene, 0);
    stack_.scene->Forward(parameters_.data(), 1);
    std::copy_n(stack_.scene->value(scene.features), SceneEncoder::kFeatures, stack_.features);
    SceneAttention(scene, *stack_.scene, details_.attention);
  } else {
    float* rest = std::ranges::copy(observation.floats(shape.ego_column), stack_.features).out;
    std::ranges::copy(observation.floats(shape.vehicles_column), rest);
  }
  if (!network_.encoder.context) return;
  conv_.Forward(observation.bits(shape.context_column).data(), stack_.pooled);
  stack_.context_output.Apply(kernels_, stack_.pooled, stack_.features + network_.encoder.vehicle_features(),
                              true);
}

Status SquashedGaussianPolicy::Load(std::span<const float> parameters) {
  DADRL_RETURN_IF_ERROR(CheckParameters("policy", network_.layout, parameters));
  std::memcpy(parameters_.data(), parameters.data(), parameters.size_bytes());
  Pack();
  return {};
}

Action SquashedGaussianPolicy::Act(const Observation& observation, Random* random) {
  Encode(observation);
  stack_.hidden1.Apply(kernels_, stack_.features, stack_.layer1, true);
  stack_.hidden2.Apply(kernels_, stack_.layer1, stack_.layer2, true);
  stack_.output.Apply(kernels_, stack_.layer2, stack_.result, false);
  std::copy_n(stack_.result, kActionSize, mean_.begin());
  for (size_t i = 0; i < kActionSize; ++i) {
    const double log_std = stack_.result[kActionSize + i];
    log_std_[i] = std::clamp(log_std, limits_.log_std_min, limits_.log_std_max);
  }
  if (random != nullptr) return Sample(*random);
  details_.log_probability.reset();
  Action action;
  std::ranges::transform(mean_, action.begin(),
                         [](double mean) { return static_cast<float>(std::tanh(mean)); });
  return action;
}

Action SquashedGaussianPolicy::Sample(Random& random) {
  Action action;
  double log_probability = 0.0;
  for (size_t i = 0; i < kActionSize; ++i) {
    const nn::SquashedSample sample =
        nn::SampleSquashed(stack_.result[i], stack_.result[kActionSize + i], random.Normal(), limits_);
    action[i] = sample.action;
    // Of the action as it is stored, so that a learner that computes it anew comes to the same.
    log_probability +=
        nn::DensityOf(action[i], stack_.result[i], stack_.result[kActionSize + i], limits_).log_probability;
  }
  details_.log_probability = log_probability;
  return action;
}

}  // namespace

Result<std::unique_ptr<PolicyModel>> MakeSquashedGaussianPolicy(const StepSpec& spec,
                                                                const ModelConfig& model) {
  DADRL_ASSIGN_OR_RETURN(const DrivingShape shape, DrivingShape::Find(spec));
  return std::make_unique<SquashedGaussianPolicy>(shape, model);
}

}  // namespace dadrl
