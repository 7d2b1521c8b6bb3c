#include "common/model/decision_transformer_policy.h"

#include <algorithm>

#include "common/model/decision_transformer.h"
#include "common/model/networks.h"

namespace dadrl {
namespace {

using nn::Value;
constexpr int kContext = DecisionTransformer::kContext;

nn::Arena ArenaFor(const DecisionTransformer& network) {
  nn::Arena measure;
  const nn::Tape measured(measure, network.graph, 1, false);
  return nn::Arena(measure.used());
}

class DecisionTransformerPolicy final : public PolicyModel {
 public:
  explicit DecisionTransformerPolicy(const DrivingShape& shape)
      : network_(shape),
        arena_(ArenaFor(network_)),
        tape_(arena_, network_.graph, 1, false),
        parameters_(network_.layout.size()) {
    FillConstants(network_, tape_, 1);
  }

  const nn::ParamLayout& layout() const override { return network_.layout; }
  Status Load(std::span<const float> parameters) override {
    DADRL_RETURN_IF_ERROR(CheckParameters("policy", network_.layout, parameters));
    std::ranges::copy(parameters, parameters_.data());
    return {};
  }
  void BeginEpisode() override { decisions_ = 0; }
  Action Act(const Observation& observation, Random* random) override;
  const Details& last() const override { return details_; }

 private:
  // Moves the rows of `value` one decision towards the past.
  void Shift(Value value);

  const DecisionTransformer network_;
  nn::Arena arena_;
  nn::Tape tape_;
  nn::FloatBuffer parameters_;
  int decisions_ = 0;  // that are in the context
  Details details_;
};

void DecisionTransformerPolicy::Shift(Value value) {
  float* const rows = tape_.input(value);
  const size_t floats = network_.graph.shape(value).floats();
  std::copy(rows + OffsetOf(network_, value, 0, 1), rows + floats, rows);
}

Action DecisionTransformerPolicy::Act(const Observation& observation, Random* /*random*/) {
  if (decisions_ == kContext) {
    Shift(network_.states);
    Shift(network_.actions);
    --decisions_;
  }
  WriteState(network_, observation, 0, tape_, 0, decisions_);
  tape_.Forward(parameters_.data(), 1);
  Action action;
  std::copy_n(tape_.value(network_.output) + OffsetOf(network_, network_.output, 0, decisions_), kActionSize,
              action.begin());
  std::ranges::copy(action,
                    tape_.input(network_.actions) + OffsetOf(network_, network_.actions, 0, decisions_));
  ++decisions_;
  return action;
}

}  // namespace

Result<std::unique_ptr<PolicyModel>> MakeDecisionTransformerPolicy(const StepSpec& spec,
                                                                   const ModelConfig& /*model*/) {
  DADRL_ASSIGN_OR_RETURN(const DrivingShape shape, DrivingShape::Find(spec));
  return std::make_unique<DecisionTransformerPolicy>(shape);
}

}  // namespace dadrl
