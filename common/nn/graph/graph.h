// A network as a static graph: nodes recorded once with fixed shapes, run forward and backward by a Tape
// without allocating.
//
// Samples and positions (time steps, vehicles, tokens) are rows, features the vector lanes, so that one
// sample that acts and a batch that trains take the same way: dense products are the lane kernels' Product
// with weights [inputs][outputs], which need no packing.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/nn/graph/node.h"
#include "common/nn/param_layout.h"

namespace dadrl::nn {

// A row of `value`: what Select gathers.
struct Position {
  Value value;
  int position = 0;
};

// Scaled dot-product attention (Vaswani et al. 2017) as Keras' MultiHeadAttention has it: `key_dim` a head,
// whatever the width of its input. Positions may lie in `groups` of equal length, each of which attends
// within itself.
struct AttentionShape {
  int heads = 1;
  int key_dim = 16;  // a multiple of sixteen
  int outputs = 16;
  int groups = 1;
  bool causal = false;  // position i of a group sees those up to i
};

// Built by one thread, then immutable. Tensors go to the layout that the building functions are given. Shapes
// that do not fit are a programmer's mistake.
class Graph {
 public:
  // Written by the caller before each Forward. A gradient reaches it only where it is `differentiable`.
  Value Input(int positions, int features, bool differentiable = false);

  // y = x W + b, each row by itself. "<name>.weight" [inputs, outputs] and "<name>.bias", initialised as
  // PyTorch's Linear.
  Value Dense(ParamLayout& layout, const std::string& name, Value input, int outputs);
  // y = x W.
  Value Project(ParamLayout& layout, const std::string& name, Value input, int outputs);
  Value Relu(Value input);
  Value Tanh(Value input);
  Value Add(Value a, Value b);
  // "<name>.gain", less one, and "<name>.bias".
  Value LayerNorm(ParamLayout& layout, const std::string& name, Value input);
  // Row i of the table "<name>" [rows, features] for an input of one feature i, a whole number; beyond the
  // table its last row.
  Value Embed(ParamLayout& layout, const std::string& name, Value input, int rows, int features);
  // [a, b] of each row.
  Value Concat(Value a, Value b);
  // These rows, in this order; of one width.
  Value Select(const std::vector<Position>& rows);
  // The largest of each feature over the positions of a group, of those that are not masked; 0 where all
  // are. `absent` of one feature, 1 where masked, or none.
  Value MaxPool(Value input, int groups, Value absent = {});
  // softmax(q k^T / sqrt(key_dim)) v by head, without projections; `absent` masks keys. A query with nothing
  // to attend to gets zeros.
  Value Attend(Value query, Value key, Value value, const AttentionShape& shape, Value absent = {});
  // The same between projections "<name>.query", ".key", ".value" and ".output", all with a bias but the
  // key's, which softmax would not see.
  Value Attention(ParamLayout& layout, const std::string& name, Value query, Value keys,
                  const AttentionShape& shape, Value absent = {});

  const RowShape& shape(Value value) const { return node(value).shape(); }
  // Whether a gradient goes there: parameters or a differentiable input lie before it.
  bool trained(Value value) const { return trained_[static_cast<size_t>(value.index)]; }
  int size() const { return static_cast<int>(nodes_.size()); }
  const Node& node(Value value) const { return *nodes_[static_cast<size_t>(value.index)]; }

 private:
  Value Append(std::unique_ptr<const Node> node, bool is_trained = false);

  std::vector<std::unique_ptr<const Node>> nodes_;
  std::vector<bool> trained_;
};

}  // namespace dadrl::nn
