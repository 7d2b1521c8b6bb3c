#include "common/model/critic_values.h"

#include <algorithm>
#include <array>

#include "common/model/networks.h"

namespace dadrl {

using nn::kLanes;

namespace {

// One block's way through the networks, laid out in an arena.
struct Block {
  Block(nn::Arena& arena, const CriticNetwork& network)
      : observations(arena, network.encoder.spec, 1),
        encoder(arena, network.encoder, 1, false),
        head(arena, network.critic1, 1),
        input(nn::TakeLanes(arena, network.critic1.hidden1.inputs, 1)),
        value(nn::TakeLanes(arena, 1, 1)) {}

  LaneObservations observations;
  EncoderActivations encoder;
  MlpActivations head;
  nn::LaneSpan input;  // [features + 2][16]
  nn::LaneSpan value;
};

nn::Arena ArenaFor(const CriticNetwork& network) {
  nn::Arena measure;
  const Block measured(measure, network);
  return nn::Arena(measure.used());
}

}  // namespace

struct CriticValues::Impl {
  Impl(const DrivingShape& spec, const ModelConfig& model)
      : network(spec, model),
        kernels(nn::LaneKernelsFor(nn::ActiveIsa())),
        arena(ArenaFor(network)),
        block(arena, network),
        parameters(network.layout.size()) {}

  CriticNetwork network;
  const nn::LaneKernels& kernels;
  nn::Arena arena;
  Block block;
  nn::FloatBuffer parameters;
  std::array<uint8_t, size_t{kLanes} * DrivingShape::kContextBytes> context{};
};

CriticValues::CriticValues(const DrivingShape& spec, const ModelConfig& model)
    : impl_(std::make_unique<Impl>(spec, model)) {}
CriticValues::~CriticValues() = default;

const nn::ParamLayout& CriticValues::layout() const { return impl_->network.layout; }

Status CriticValues::Load(std::span<const float> parameters) {
  const nn::ParamLayout& layout = impl_->network.layout;
  if (parameters.size() != layout.size()) {
    return Fail(
        ErrorCode::kInvalidArgument,
        "critics of {} parameters where the configured networks have {}: model.* or observation.* differ",
        parameters.size(), layout.size());
  }
  if (const std::string_view tensor = layout.FirstNonFinite(parameters); !tensor.empty()) {
    return Fail(ErrorCode::kCorrupt, "critic parameter {} is not finite: not loaded", tensor);
  }
  std::ranges::copy(parameters, impl_->parameters.data());
  return {};
}

void CriticValues::Evaluate(ColumnRows observations, std::span<const float> actions, std::span<float> q1,
                            std::span<float> q2) {
  Impl& impl = *impl_;
  Block& block = impl.block;
  const int features = impl.network.encoder.features();
  const std::span<const uint8_t> context = observations.bits(impl.network.encoder.spec.context_column);
  for (int first = 0; first < observations.rows(); first += kLanes) {
    const int count = std::min(kLanes, observations.rows() - first);
    const auto planes = context.subspan(static_cast<size_t>(first) * DrivingShape::kContextBytes,
                                        static_cast<size_t>(count) * DrivingShape::kContextBytes);
    std::ranges::fill(std::ranges::copy(planes, impl.context.begin()).out, impl.context.end(), uint8_t{0});
    block.observations.Pack(impl.kernels, observations, impl.context.data(), first / kLanes);
    EncoderForward(impl.kernels, impl.network.encoder, impl.parameters.data(), block.observations,
                   block.encoder, block.input);
    const float* action = &actions[static_cast<size_t>(first) * kActionSize];
    for (int i = 0; i < count; ++i) {
      for (int d = 0; d < kActionSize; ++d) block.input.From(features + d).data[i] = *action++;
    }
    for (const auto& [critic, values] :
         {std::pair(&impl.network.critic1, q1), std::pair(&impl.network.critic2, q2)}) {
      MlpForward(impl.kernels, *critic, impl.parameters.data(), block.input, 1, block.head, block.value);
      std::copy_n(block.value.data, count, values.begin() + first);
    }
  }
}

}  // namespace dadrl
