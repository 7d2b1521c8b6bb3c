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

class CriticValues final : public ValueModel {
 public:
  CriticValues(const DrivingShape& spec, const ModelConfig& model)
      : network_(spec, model),
        kernels_(nn::LaneKernelsFor(ActiveIsa())),
        arena_(ArenaFor(network_)),
        block_(arena_, network_),
        parameters_(network_.layout.size()) {}

  const nn::ParamLayout& layout() const override { return network_.layout; }
  Status Load(std::span<const float> parameters) override;
  std::vector<Values> Evaluate(const Columns& observations, std::span<const float> actions) override;

 private:
  // Takes up to sixteen observations and actions from `first` on.
  void Fill(const Columns& observations, std::span<const float> actions, int first, int count);

  const CriticNetwork network_;
  const nn::LaneKernels& kernels_;
  nn::Arena arena_;
  Block block_;
  nn::FloatBuffer parameters_;
  std::array<uint8_t, size_t{kLanes} * DrivingShape::kContextBytes> context_{};
};

Status CriticValues::Load(std::span<const float> parameters) {
  DADRL_RETURN_IF_ERROR(CheckParameters("critic", network_.layout, parameters));
  std::ranges::copy(parameters, parameters_.data());
  return {};
}

void CriticValues::Fill(const Columns& observations, std::span<const float> actions, int first, int count) {
  const std::span<const uint8_t> context = observations.bits(network_.encoder.spec.context_column);
  const auto planes = context.subspan(static_cast<size_t>(first) * DrivingShape::kContextBytes,
                                      static_cast<size_t>(count) * DrivingShape::kContextBytes);
  std::ranges::fill(std::ranges::copy(planes, context_.begin()).out, context_.end(), uint8_t{0});
  block_.observations.Pack(kernels_, observations, context_.data(), first / kLanes);
  EncoderForward(kernels_, network_.encoder, parameters_.data(), block_.observations, block_.encoder,
                 block_.input);
  const float* action = &actions[static_cast<size_t>(first) * kActionSize];
  for (int i = 0; i < count; ++i) {
    for (int d = 0; d < kActionSize; ++d) {
      block_.input.From(network_.encoder.features() + d).data[i] = *action++;
    }
  }
}

std::vector<ValueModel::Values> CriticValues::Evaluate(const Columns& observations,
                                                       std::span<const float> actions) {
  const auto rows = static_cast<size_t>(observations.rows());
  std::vector<Values> values = {{"q1", std::vector<float>(rows)}, {"q2", std::vector<float>(rows)}};
  for (int first = 0; first < observations.rows(); first += kLanes) {
    const int count = std::min(kLanes, observations.rows() - first);
    Fill(observations, actions, first, count);
    for (const auto& [critic, result] :
         {std::pair(&network_.critic1, &values[0].values), std::pair(&network_.critic2, &values[1].values)}) {
      MlpForward(kernels_, *critic, parameters_.data(), block_.input, 1, block_.head, block_.value);
      std::copy_n(block_.value.data, count, result->begin() + first);
    }
  }
  return values;
}

}  // namespace

Result<std::unique_ptr<ValueModel>> MakeCriticValues(const StepSpec& spec, const ModelConfig& model) {
  DADRL_ASSIGN_OR_RETURN(const DrivingShape shape, DrivingShape::Find(spec));
  return std::make_unique<CriticValues>(shape, model);
}

}  // namespace dadrl
