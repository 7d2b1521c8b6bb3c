#include "common/nn/graph/attend.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace dadrl::nn {
namespace {

ptrdiff_t Padded(int n) { return static_cast<ptrdiff_t>(RoundUp(static_cast<size_t>(n), kAlignedFloats)); }

}  // namespace

AttendNode::AttendNode(const std::vector<Value>& inputs, int query_positions, int key_positions,
                       const AttentionShape& attention)
    : Node({query_positions, attention.heads * attention.key_dim}, inputs),
      attention_(attention),
      queries_(query_positions / attention.groups),
      keys_(key_positions / attention.groups),
      weight_stride_(Padded(keys_)) {
  assert(attention.key_dim % kLanes == 0);
  assert(queries_ * attention.groups == query_positions && keys_ * attention.groups == key_positions);
}

size_t AttendNode::kept_floats(int batch) const {
  return static_cast<size_t>(batch * attention_.groups * attention_.heads * queries_ * weight_stride_);
}

size_t AttendNode::scratch_floats() const {
  return static_cast<size_t>(attention_.key_dim * weight_stride_ + queries_ * weight_stride_);
}

AttendNode::Head AttendNode::HeadAt(int group, int head) const {
  const ptrdiff_t first = ptrdiff_t{head} * attention_.key_dim;
  return {.query = group * queries_ * shape().stride() + first,
          .key = group * keys_ * shape().stride() + first,
          .weights = (group * attention_.heads + head) * queries_ * weight_stride_,
          .absent = ptrdiff_t{group} * keys_ * kLanes};
}

template <typename Visit>
void AttendNode::ForEachHead(const NodePass& pass, Visit visit) const {
  for (int group = 0; group < pass.batch * attention_.groups; ++group) {
    for (int head = 0; head < attention_.heads; ++head) visit(HeadAt(group, head));
  }
}

ScoreRows AttendNode::Scores(const NodePass& pass, const Head& head, float* scores) const {
  return {.queries = queries_,
          .keys = keys_,
          .stride = weight_stride_,
          .scores = scores,
          .weights = pass.kept + head.weights,
          .absent = pass.inputs.size() > 3 ? pass.inputs[3] + head.absent : nullptr,
          .causal = attention_.causal,
          .scale = 1.0f / std::sqrt(static_cast<float>(attention_.key_dim))};
}

void AttendNode::Transpose(const NodePass& pass, const float* rows) const {
  for (int first = 0; first < keys_; first += kLanes) {
    pass.lanes.to_lanes(rows + first * shape().stride(), shape().stride(), std::min(kLanes, keys_ - first),
                        attention_.key_dim, pass.scratch + ptrdiff_t{first} * attention_.key_dim);
  }
}

void AttendNode::MultiplyTransposed(const NodePass& pass, const float* a, float* c) const {
  pass.lanes.multiply({.rows = queries_,
                       .blocks = static_cast<int>(weight_stride_ / kLanes),
                       .depth = attention_.key_dim,
                       .a = a,
                       .a_row = shape().stride(),
                       .a_depth = 1,
                       .b = pass.scratch,
                       .b_block = ptrdiff_t{kLanes} * attention_.key_dim,
                       .b_depth = kLanes,
                       .c = c,
                       .c_block = kLanes,
                       .c_row = weight_stride_});
}

void AttendNode::Forward(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  ForEachHead(pass, [&](const Head& head) {
    float* const weights = pass.kept + head.weights;
    Transpose(pass, pass.inputs[1] + head.key);
    MultiplyTransposed(pass, pass.inputs[0] + head.query, weights);
    pass.rows.softmax_forward(Scores(pass, head, weights));
    pass.lanes.multiply({.rows = queries_,
                         .blocks = attention_.key_dim / kLanes,
                         .depth = keys_,
                         .a = weights,
                         .a_row = weight_stride_,
                         .a_depth = 1,
                         .b = pass.inputs[2] + head.key,
                         .b_block = kLanes,
                         .b_depth = stride,
                         .c = pass.output + head.query,
                         .c_block = kLanes,
                         .c_row = stride});
  });
}

void AttendNode::Backward(const NodePass& pass) const {
  const ptrdiff_t stride = shape().stride();
  float* const scores = pass.scratch + attention_.key_dim * weight_stride_;
  // c [rows][key_dim] += a^T or a, of weights or scores, times rows of features.
  const auto add = [&](const float* a, bool transposed, const float* rows, float* c) {
    pass.lanes.multiply({.rows = transposed ? keys_ : queries_,
                         .blocks = attention_.key_dim / kLanes,
                         .depth = transposed ? queries_ : keys_,
                         .a = a,
                         .a_row = transposed ? 1 : weight_stride_,
                         .a_depth = transposed ? weight_stride_ : 1,
                         .b = rows,
                         .b_block = kLanes,
                         .b_depth = stride,
                         .c = c,
                         .c_block = kLanes,
                         .c_row = stride,
                         .accumulate = true});
  };
  ForEachHead(pass, [&](const Head& head) {
    const float* const output = pass.output_gradient + head.query;
    Transpose(pass, pass.inputs[2] + head.key);
    MultiplyTransposed(pass, output, scores);
    pass.rows.softmax_backward(Scores(pass, head, scores));
    if (float* const query = pass.input_gradients[0]) {
      add(scores, false, pass.inputs[1] + head.key, query + head.query);
    }
    if (float* const key = pass.input_gradients[1]) {
      add(scores, true, pass.inputs[0] + head.query, key + head.key);
    }
    if (float* const value = pass.input_gradients[2]) {
      add(pass.kept + head.weights, true, output, value + head.key);
    }
  });
}

}  // namespace dadrl::nn
