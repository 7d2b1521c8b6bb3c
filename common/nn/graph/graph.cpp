#include "common/nn/graph/graph.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "common/nn/graph/attend.h"
#include "common/nn/graph/dense.h"
#include "common/nn/graph/structure.h"

namespace dadrl::nn {
namespace {

std::vector<Value> With(std::vector<Value> inputs, Value absent) {
  if (absent.index >= 0) inputs.push_back(absent);
  return inputs;
}

}  // namespace

Value Graph::Append(std::unique_ptr<const Node> node, bool is_trained) {
  trained_.push_back(is_trained ||
                     std::ranges::any_of(node->inputs(), [&](Value input) { return trained(input); }));
  nodes_.push_back(std::move(node));
  return {size() - 1};
}

Value Graph::Input(int positions, int features, bool differentiable) {
  return Append(std::make_unique<InputNode>(RowShape{positions, features}), differentiable);
}

Value Graph::Dense(ParamLayout& layout, const std::string& name, Value input, int outputs) {
  return Append(std::make_unique<DenseNode>(layout, name, input, shape(input), outputs, true), true);
}

Value Graph::Project(ParamLayout& layout, const std::string& name, Value input, int outputs) {
  return Append(std::make_unique<DenseNode>(layout, name, input, shape(input), outputs, false), true);
}

Value Graph::Relu(Value input) {
  return Append(std::make_unique<ReluNode>(shape(input), std::vector{input}));
}

Value Graph::Tanh(Value input) {
  return Append(std::make_unique<TanhNode>(shape(input), std::vector{input}));
}

Value Graph::Add(Value a, Value b) {
  assert(shape(a) == shape(b));
  return Append(std::make_unique<AddNode>(shape(a), std::vector{a, b}));
}

Value Graph::LayerNorm(ParamLayout& layout, const std::string& name, Value input) {
  return Append(std::make_unique<LayerNormNode>(layout, name, input, shape(input)), true);
}

Value Graph::Embed(ParamLayout& layout, const std::string& name, Value input, int rows, int features) {
  assert(shape(input).features == 1);
  return Append(std::make_unique<EmbedNode>(layout, name, input, shape(input).positions, rows, features),
                true);
}

Value Graph::Concat(Value a, Value b) {
  assert(shape(a).positions == shape(b).positions);
  return Append(std::make_unique<ConcatNode>(a, shape(a), b, shape(b)));
}

Value Graph::Select(const std::vector<Position>& rows) {
  std::vector<Value> inputs;
  std::vector<SelectNode::Source> sources;
  const int features = shape(rows.front().value).features;
  for (const Position& row : rows) {
    assert(shape(row.value).features == features && row.position < shape(row.value).positions);
    auto found = std::ranges::find(inputs, row.value.index, &Value::index);
    if (found == inputs.end()) found = inputs.insert(found, row.value);
    sources.push_back({static_cast<size_t>(found - inputs.begin()), row.position, shape(row.value).floats()});
  }
  return Append(std::make_unique<SelectNode>(std::move(inputs), std::move(sources), features));
}

Value Graph::MaxPool(Value input, int groups, Value absent) {
  return Append(std::make_unique<MaxPoolNode>(With({input}, absent), shape(input), groups));
}

Value Graph::Attend(Value query, Value key, Value value, const AttentionShape& attention, Value absent) {
  assert(shape(key) == shape(value));
  assert(shape(query).features == attention.heads * attention.key_dim);
  return Append(std::make_unique<AttendNode>(With({query, key, value}, absent), shape(query).positions,
                                             shape(key).positions, attention));
}

Value Graph::Attention(ParamLayout& layout, const std::string& name, Value query, Value keys,
                       const AttentionShape& attention, Value absent) {
  const int inner = attention.heads * attention.key_dim;
  const Value q = Dense(layout, name + ".query", query, inner);
  const Value k = Project(layout, name + ".key", keys, inner);
  const Value v = Dense(layout, name + ".value", keys, inner);
  return Dense(layout, name + ".output", Attend(q, k, v, attention, absent), attention.outputs);
}

}  // namespace dadrl::nn
