#include "common/nn/graph/dense.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace dadrl::nn {
namespace {

// So many rows at a time stay in the first cache while all outputs are made of them.
constexpr int kRowsAtOnce = 96;
// Of an embedding's table, as GPT initialises it (Radford et al. 2018).
constexpr float kEmbeddingBound = 0.02f;

int Blocks(ptrdiff_t stride) { return static_cast<int>(stride / kLanes); }

}  // namespace

DenseNode::DenseNode(ParamLayout& layout, const std::string& name, Value input, const RowShape& input_shape,
                     int outputs, bool bias)
    : Node({input_shape.positions, outputs}, {input}), input_(input_shape) {
  const float bound = 1.0f / std::sqrt(static_cast<float>(input_.features));
  weight_ = layout.Add(name + ".weight", {input_.features, outputs}, bound);
  if (bias) bias_ = layout.Add(name + ".bias", {outputs}, bound);
}

size_t DenseNode::scratch_floats() const {
  // Forward the whole rows, backward the transpose in blocks of sixteen inputs.
  return std::max(static_cast<size_t>(input_.features * shape().stride()),
                  static_cast<size_t>(input_.stride() * shape().features));
}

const float* DenseNode::WholeRows(const float* weight, float* scratch) const {
  const ptrdiff_t stride = shape().stride();
  const int outputs = shape().features;
  if (stride == outputs) return weight;
  for (int i = 0; i < input_.features; ++i) {
    float* const end = std::copy_n(weight + i * outputs, outputs, scratch + i * stride);
    std::fill(end, scratch + (i + 1) * stride, 0.0f);
  }
  return scratch;
}

void DenseNode::Forward(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  const float* const weight = WholeRows(pass.parameters + weight_, pass.scratch);
  for (int first = 0; first < Rows(pass); first += kRowsAtOnce) {
    const int rows = std::min(kRowsAtOnce, Rows(pass) - first);
    float* const output = pass.output + first * stride;
    if (bias_) {
      const float* const bias = pass.parameters + *bias_;  // padded with zeros as every tensor
      for (int r = 0; r < rows; ++r) std::copy_n(bias, stride, output + r * stride);
    }
    pass.lanes.multiply({.rows = rows,
                         .blocks = Blocks(stride),
                         .depth = input_.features,
                         .a = pass.inputs[0] + first * input_.stride(),
                         .a_row = input_.stride(),
                         .a_depth = 1,
                         .b = weight,
                         .b_block = kLanes,
                         .b_depth = stride,
                         .c = output,
                         .c_block = kLanes,
                         .c_row = stride,
                         .accumulate = bias_.has_value()});
  }
}

void DenseNode::Backward(const NodePass& pass) const {
  AddWeightGradient(pass);
  if (pass.input_gradients[0] != nullptr) AddInputGradient(pass);
}

void DenseNode::AddWeightGradient(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  if (bias_) pass.rows.sum_rows(pass.output_gradient, Rows(pass), stride, pass.gradients + *bias_);
  pass.lanes.multiply({.rows = input_.features,
                       .blocks = Blocks(stride),
                       .depth = Rows(pass),
                       .a = pass.inputs[0],
                       .a_row = 1,
                       .a_depth = input_.stride(),
                       .b = pass.output_gradient,
                       .b_block = kLanes,
                       .b_depth = stride,
                       .c = pass.gradients + weight_,
                       .c_block = kLanes,
                       .c_row = shape().features,
                       .accumulate = true,
                       .last_width = shape().features - static_cast<int>(stride) + kLanes});
}

void DenseNode::AddInputGradient(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  const int outputs = shape().features;
  const float* const weight = pass.parameters + weight_;
  for (int first = 0; first < input_.features; first += kLanes) {
    pass.lanes.to_lanes(weight + first * outputs, outputs, std::min(kLanes, input_.features - first), outputs,
                        pass.scratch + first * outputs);
  }
  for (int first = 0; first < Rows(pass); first += kRowsAtOnce) {
    pass.lanes.multiply({.rows = std::min(kRowsAtOnce, Rows(pass) - first),
                         .blocks = Blocks(input_.stride()),
                         .depth = outputs,
                         .a = pass.output_gradient + first * stride,
                         .a_row = stride,
                         .a_depth = 1,
                         .b = pass.scratch,
                         .b_block = ptrdiff_t{kLanes} * outputs,
                         .b_depth = kLanes,
                         .c = pass.input_gradients[0] + first * input_.stride(),
                         .c_block = kLanes,
                         .c_row = input_.stride(),
                         .accumulate = true});
  }
}

EmbedNode::EmbedNode(ParamLayout& layout, const std::string& name, Value input, int positions, int rows,
                     int features)
    : Node({positions, features}, {input}),
      rows_(rows),
      table_(layout.Add(name, {rows, features}, kEmbeddingBound)) {}

size_t EmbedNode::RowOf(const NodePass& pass, int position) const {
  const float index = pass.inputs[0][ptrdiff_t{position} * kLanes];
  const int row = static_cast<int>(std::clamp(index, 0.0f, static_cast<float>(rows_ - 1)));
  return table_ + static_cast<size_t>(row * shape().features);
}

void EmbedNode::Forward(const NodePass& pass) const {
  for (int i = 0; i < Rows(pass); ++i) {
    std::copy_n(pass.parameters + RowOf(pass, i), shape().features, pass.output + i * shape().stride());
  }
}

void EmbedNode::Backward(const NodePass& pass) const {
  for (int i = 0; i < Rows(pass); ++i) {
    const float* const from = pass.output_gradient + i * shape().stride();
    float* const to = pass.gradients + RowOf(pass, i);
    for (int f = 0; f < shape().features; ++f) to[f] += from[f];
  }
}

LayerNormNode::LayerNormNode(ParamLayout& layout, const std::string& name, Value input, const RowShape& shape)
    : Node(shape, {input}),
      gain_(layout.Add(name + ".gain", {shape.features}, 0.0f)),
      bias_(layout.Add(name + ".bias", {shape.features}, 0.0f)) {}

size_t LayerNormNode::kept_floats(int batch) const {
  const auto rows = static_cast<size_t>(batch * shape().positions);
  return static_cast<size_t>(batch) * shape().floats() + RoundUp(rows, kAlignedFloats);
}

NormRows LayerNormNode::RowsOf(const NodePass& pass) const {
  return {.rows = Rows(pass),
          .features = shape().features,
          .stride = shape().stride(),
          .gain = pass.parameters + gain_,
          .bias = pass.parameters + bias_,
          .normalized = pass.kept,
          .inverse_deviation = pass.kept + Floats(pass)};
}

void LayerNormNode::Forward(const NodePass& pass) const {
  NormRows rows = RowsOf(pass);
  rows.input = pass.inputs[0];
  rows.output = pass.output;
  pass.rows.layer_norm_forward(rows);
}

void LayerNormNode::Backward(const NodePass& pass) const {
  NormRows rows = RowsOf(pass);
  rows.output_gradient = pass.output_gradient;
  rows.input_gradient = pass.input_gradients[0];
  rows.gain_gradient = pass.gradients + gain_;
  rows.bias_gradient = pass.gradients + bias_;
  pass.rows.layer_norm_backward(rows);
}

}  // namespace dadrl::nn
