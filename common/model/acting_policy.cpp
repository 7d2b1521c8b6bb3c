#include "common/model/acting_policy.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "common/model/acting_stae.h"
#include "common/model/networks.h"

namespace dadrl {
namespace {

// The packed networks and their scratch, laid out in an arena.
struct Stack {
  Stack(nn::Arena& arena, const PolicyNetwork& network, const ModelConfig& model)
      : hidden1(arena, network.encoder.features(), model.hidden),
        hidden2(arena, model.hidden, model.hidden),
        output(arena, model.hidden, 2 * kActionSize),
        pooled(arena.Allocate(nn::kConvFeatures)),
        features(arena.Allocate(static_cast<size_t>(network.encoder.features()))),
        layer1(arena.Allocate(static_cast<size_t>(hidden1.padded))),
        layer2(arena.Allocate(static_cast<size_t>(hidden2.padded))),
        result(arena.Allocate(static_cast<size_t>(output.padded))) {
    if (network.encoder.stae) stae.emplace(arena, network.encoder.spec);
    if (network.encoder.context)
      context_output = DenseRow(arena, nn::kConvFeatures, ContextEncoder::kFeatures);
  }

  std::optional<ActingStae> stae;
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

}  // namespace

struct ActingPolicy::Impl {
  Impl(const DrivingShape& spec, const ModelConfig& model_config)
      : model(model_config),
        network(spec, model),
        kernels(nn::LaneKernelsFor(nn::ActiveIsa())),
        arena(ArenaFor(network, model)),
        stack(arena, network, model),
        parameters(network.layout.size()) {
    if (network.encoder.stae) details.attention.resize(static_cast<size_t>(spec.vehicles));
  }

  void Pack();
  void Encode(const Observation& observation);

  ModelConfig model;
  PolicyNetwork network;
  const nn::LaneKernels& kernels;
  nn::Arena arena;
  Stack stack;
  nn::SingleImageConvStack conv;
  nn::FloatBuffer parameters;
  Details details;
};

void ActingPolicy::Impl::Pack() {
  const float* p = parameters.data();
  const auto pack = [&](DenseRow& row, const nn::Linear& layer) {
    row.Pack(p + layer.weight, p + layer.bias);
  };
  if (stack.stae) stack.stae->Pack(*network.encoder.stae, p);
  if (network.encoder.context) {
    conv.Pack(network.encoder.context->ConvParams(p));
    pack(stack.context_output, network.encoder.context->output);
  }
  pack(stack.hidden1, network.head.hidden1);
  pack(stack.hidden2, network.head.hidden2);
  pack(stack.output, network.head.output);
}

void ActingPolicy::Impl::Encode(const Observation& observation) {
  if (stack.stae) {
    stack.stae->Forward(kernels, observation, stack.features, details.attention);
  } else {
    const DrivingShape& shape = network.encoder.spec;
    float* rest = std::ranges::copy(observation.floats(shape.ego_column), stack.features).out;
    std::ranges::copy(observation.floats(shape.vehicles_column), rest);
  }
  if (!network.encoder.context) return;
  conv.Forward(observation.bits(network.encoder.spec.context_column).data(), stack.pooled);
  stack.context_output.Apply(kernels, stack.pooled, stack.features + network.encoder.vehicle_features(),
                             true);
}

ActingPolicy::ActingPolicy(const DrivingShape& spec, const ModelConfig& model)
    : impl_(std::make_unique<Impl>(spec, model)) {}
ActingPolicy::~ActingPolicy() = default;
ActingPolicy::ActingPolicy(ActingPolicy&&) noexcept = default;
ActingPolicy& ActingPolicy::operator=(ActingPolicy&&) noexcept = default;

size_t ActingPolicy::parameter_count() const { return impl_->network.layout.size(); }
uint64_t ActingPolicy::layout_hash() const { return impl_->network.layout.hash(); }
const ActingPolicy::Details& ActingPolicy::last() const { return impl_->details; }

Status ActingPolicy::Load(std::span<const float> parameters) {
  if (parameters.size() != parameter_count()) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "policy of {} parameters where the configured networks have {}: model.* or observation.* differ",
        parameters.size(), parameter_count());
  }
  if (const std::string_view tensor = impl_->network.layout.FirstNonFinite(parameters); !tensor.empty()) {
    return Fail(ErrorCode::kCorrupt, "policy parameter {} is not finite: not loaded", tensor);
  }
  std::memcpy(impl_->parameters.data(), parameters.data(), parameters.size_bytes());
  impl_->Pack();
  return {};
}

Action ActingPolicy::Act(const Observation& observation, Random* random) {
  Impl& impl = *impl_;
  Stack& stack = impl.stack;
  impl.Encode(observation);
  stack.hidden1.Apply(impl.kernels, stack.features, stack.layer1, true);
  stack.hidden2.Apply(impl.kernels, stack.layer1, stack.layer2, true);
  stack.output.Apply(impl.kernels, stack.layer2, stack.result, false);
  Action action;
  for (size_t i = 0; i < kActionSize; ++i) {
    const double mean = static_cast<double>(stack.result[i]);
    const double log_std = std::clamp(static_cast<double>(stack.result[kActionSize + i]),
                                      impl.model.log_std_min, impl.model.log_std_max);
    impl.details.mean[i] = static_cast<float>(mean);
    impl.details.log_std[i] = static_cast<float>(log_std);
    const double noise = random == nullptr ? 0.0 : random->Normal();
    action[i] = static_cast<float>(std::tanh(mean + std::exp(log_std) * noise));
  }
  return action;
}

}  // namespace dadrl
