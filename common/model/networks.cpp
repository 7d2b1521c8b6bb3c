#include "common/model/networks.h"

namespace dadrl {

PolicyNetwork::PolicyNetwork(const DrivingShape& spec, const ModelConfig& model)
    : encoder(Encoder::Add(layout, "encoder", spec, model)) {
  encoder_range = {0, layout.size()};
  head = Mlp::Add(layout, "policy", encoder.features(), model.hidden, 2 * kActionSize, false);
  head_range = {encoder_range.count, layout.size() - encoder_range.count};
}

ValueNetwork::ValueNetwork(const DrivingShape& spec, const ModelConfig& model)
    : encoder(Encoder::Add(layout, "encoder", spec, model)) {
  encoder_range = {0, layout.size()};
  head = Mlp::Add(layout, "value", encoder.features(), model.hidden, 1, model.critic_layer_norm);
}

CriticNetwork::CriticNetwork(const DrivingShape& spec, const ModelConfig& model)
    : encoder(Encoder::Add(layout, "encoder", spec, model)) {
  encoder_range = {0, layout.size()};
  const int inputs = encoder.features() + kActionSize;
  critic1 = Mlp::Add(layout, "critic1", inputs, model.hidden, 1, model.critic_layer_norm);
  critic2 = Mlp::Add(layout, "critic2", inputs, model.hidden, 1, model.critic_layer_norm);
  head_range = {encoder_range.count, layout.size() - encoder_range.count};
}

Status CheckParameters(std::string_view what, const nn::ParamLayout& layout,
                       std::span<const float> parameters) {
  if (parameters.size() != layout.size()) {
    return Fail(ErrorCode::kInvalidArgument,
                "{} of {} parameters where the configured networks have {}: model.* or observation.* differ",
                what, parameters.size(), layout.size());
  }
  const std::string_view tensor = layout.FirstNonFinite(parameters);
  if (tensor.empty()) return {};
  return Fail(ErrorCode::kCorrupt, "{} parameter {} is not finite: not loaded", what, tensor);
}

}  // namespace dadrl
