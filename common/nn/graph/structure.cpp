#include "common/nn/graph/structure.h"

#include <algorithm>

namespace dadrl::nn {

void ReluNode::Forward(const NodePass& pass) const {
  pass.lanes.relu(pass.inputs[0], pass.output, Floats(pass));
}

void ReluNode::Backward(const NodePass& pass) const {
  pass.rows.relu_backward(pass.output, pass.output_gradient, pass.input_gradients[0], Floats(pass));
}

void TanhNode::Forward(const NodePass& pass) const {
  pass.rows.tanh(pass.inputs[0], pass.output, Floats(pass));
}

void TanhNode::Backward(const NodePass& pass) const {
  pass.rows.tanh_backward(pass.output, pass.output_gradient, pass.input_gradients[0], Floats(pass));
}

void AddNode::Forward(const NodePass& pass) const {
  std::copy_n(pass.inputs[0], Floats(pass), pass.output);
  pass.rows.add(pass.inputs[1], pass.output, Floats(pass));
}

void AddNode::Backward(const NodePass& pass) const {
  for (float* const gradient : pass.input_gradients) {
    if (gradient != nullptr) pass.rows.add(pass.output_gradient, gradient, Floats(pass));
  }
}

ConcatNode::ConcatNode(Value a, const RowShape& a_shape, Value b, const RowShape& b_shape)
    : Node({a_shape.positions, a_shape.features + b_shape.features}, {a, b}), parts_{a_shape, b_shape} {}

void ConcatNode::Forward(const NodePass& pass) const {
  for (int row = 0; row < Rows(pass); ++row) {
    float* to = pass.output + row * shape().stride();
    for (size_t i = 0; i < 2; ++i) {
      to = std::copy_n(pass.inputs[i] + row * parts_[i].stride(), parts_[i].features, to);
    }
  }
}

void ConcatNode::Backward(const NodePass& pass) const {
  for (int row = 0; row < Rows(pass); ++row) {
    const float* from = pass.output_gradient + row * shape().stride();
    for (size_t i = 0; i < 2; from += parts_[i].features, ++i) {
      if (pass.input_gradients[i] == nullptr) continue;
      float* const to = pass.input_gradients[i] + row * parts_[i].stride();
      for (int f = 0; f < parts_[i].features; ++f) to[f] += from[f];
    }
  }
}

void SelectNode::Forward(const NodePass& pass) const {
  float* to = pass.output;
  for (size_t sample = 0; sample < static_cast<size_t>(pass.batch); ++sample) {
    for (const Source& source : sources_) {
      const float* const from = pass.inputs[source.input] + sample * source.floats;
      to = std::copy_n(from + source.position * shape().stride(), shape().stride(), to);
    }
  }
}

void SelectNode::Backward(const NodePass& pass) const {
  const float* from = pass.output_gradient;
  for (size_t sample = 0; sample < static_cast<size_t>(pass.batch); ++sample) {
    for (const Source& source : sources_) {
      if (float* const gradient = pass.input_gradients[source.input]) {
        pass.rows.add(from, gradient + sample * source.floats + source.position * shape().stride(),
                      static_cast<size_t>(shape().stride()));
      }
      from += shape().stride();
    }
  }
}

void MaxPoolNode::Forward(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  for (int group = 0; group < Rows(pass); ++group) {
    float* const best = pass.output + group * stride;
    float* const row = pass.kept + group * stride;
    std::fill_n(best, stride, 0.0f);
    std::fill_n(row, stride, -1.0f);
    for (int i = group * length_; i < (group + 1) * length_; ++i) {
      if (pass.inputs.size() > 1 && pass.inputs[1][ptrdiff_t{i} * kLanes] > 0.5f) continue;
      const float* const from = pass.inputs[0] + i * stride;
      const auto index = static_cast<float>(i - group * length_);
      for (ptrdiff_t f = 0; f < stride; ++f) {
        const bool kept = row[f] >= 0.0f && best[f] >= from[f];  // NaN takes over
        best[f] = kept ? best[f] : from[f];
        row[f] = kept ? row[f] : index;
      }
    }
  }
}

void MaxPoolNode::Backward(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  for (int group = 0; group < Rows(pass); ++group) {
    const float* const row = pass.kept + group * stride;
    float* const to = pass.input_gradients[0] + group * length_ * stride;
    for (ptrdiff_t f = 0; f < shape().features; ++f) {
      if (row[f] >= 0.0f)
        to[static_cast<ptrdiff_t>(row[f]) * stride + f] += pass.output_gradient[group * stride + f];
    }
  }
}

}  // namespace dadrl::nn
