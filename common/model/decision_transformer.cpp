#include "common/model/decision_transformer.h"

#include <algorithm>
#include <string>

namespace dadrl {
namespace {

using nn::Graph;
using nn::Value;
using Network = DecisionTransformer;

constexpr int kTokens = 3;  // of a decision: return, state, action

// Every third token from `first` on: those of one kind.
Value TokensOfKind(Graph& graph, Value tokens, int first) {
  std::vector<nn::Position> rows;
  for (int i = 0; i < Network::kContext; ++i) rows.push_back({tokens, kTokens * i + first});
  return graph.Select(rows);
}

Value Interleave(Graph& graph, Value returns, Value states, Value actions) {
  std::vector<nn::Position> rows;
  for (int i = 0; i < Network::kContext; ++i) {
    rows.insert(rows.end(), {{returns, i}, {states, i}, {actions, i}});
  }
  return graph.Select(rows);
}

Value AddBlock(Network& n, const std::string& name, Value x) {
  const Value normal = n.graph.LayerNorm(n.layout, name + ".norm1", x);
  const nn::AttentionShape shape{.key_dim = Network::kUnits, .outputs = Network::kUnits, .causal = true};
  x = n.graph.Add(x, n.graph.Attention(n.layout, name + ".attention", normal, normal, shape));
  const Value inner = n.graph.Relu(n.graph.Dense(
      n.layout, name + ".inner", n.graph.LayerNorm(n.layout, name + ".norm2", x), Network::kInnerUnits));
  return n.graph.Add(x, n.graph.Dense(n.layout, name + ".outer", inner, Network::kUnits));
}

}  // namespace

DecisionTransformer::DecisionTransformer(const DrivingShape& shape) : spec(shape) {
  returns = graph.Input(kContext, 1);
  states = graph.Input(kContext, state_features());
  actions = graph.Input(kContext, kActionSize);
  places = graph.Input(kContext, 1);
  const Value place = graph.Embed(layout, "place", places, kContext, kUnits);
  const auto embed = [&](const char* name, Value input) {
    return graph.Add(graph.Dense(layout, name, input, kUnits), place);
  };
  const Value return_tokens = embed("return", returns);
  const Value state_tokens = embed("state", states);
  const Value action_tokens = embed("action", actions);
  Value x = graph.LayerNorm(layout, "norm", Interleave(graph, return_tokens, state_tokens, action_tokens));
  for (int i = 0; i < kBlocks; ++i) x = AddBlock(*this, "block" + std::to_string(i + 1), x);
  x = graph.LayerNorm(layout, "last_norm", x);
  output = graph.Tanh(graph.Dense(layout, "output", TokensOfKind(graph, x, 1), kActionSize));
}

size_t OffsetOf(const DecisionTransformer& network, Value value, int sample, int place) {
  const nn::RowShape& shape = network.graph.shape(value);
  return static_cast<size_t>(sample) * shape.floats() + static_cast<size_t>(place * shape.stride());
}

void FillConstants(const DecisionTransformer& network, nn::Tape& tape, int batch) {
  for (int sample = 0; sample < batch; ++sample) {
    for (int i = 0; i < Network::kContext; ++i) {
      tape.input(network.returns)[OffsetOf(network, network.returns, sample, i)] = Network::kSuccess;
      tape.input(network.places)[OffsetOf(network, network.places, sample, i)] = static_cast<float>(i);
    }
  }
}

void WriteState(const DecisionTransformer& network, ColumnRows observations, int row, nn::Tape& tape,
                int sample, int place) {
  const DrivingShape& spec = network.spec;
  constexpr size_t kEgo = DrivingShape::kEgoFeatures;
  constexpr size_t kVehicle = DrivingShape::kVehicleFeatures;
  const auto newest = static_cast<size_t>(spec.history) - 1;
  const auto index = static_cast<size_t>(row);
  const std::span<const float> ego =
      observations.floats(spec.ego_column).subspan(index * static_cast<size_t>(spec.ego_floats()));
  const std::span<const float> vehicles =
      observations.floats(spec.vehicles_column).subspan(index * static_cast<size_t>(spec.vehicle_floats()));
  float* to = tape.input(network.states) + OffsetOf(network, network.states, sample, place);
  to = std::ranges::copy(ego.subspan(newest * kEgo, kEgo), to).out;
  for (size_t v = 0; v < static_cast<size_t>(spec.vehicles); ++v) {
    const size_t last_row = (v + 1) * static_cast<size_t>(spec.history) - 1;
    to = std::ranges::copy(vehicles.subspan(last_row * kVehicle, kVehicle), to).out;
  }
}

}  // namespace dadrl
