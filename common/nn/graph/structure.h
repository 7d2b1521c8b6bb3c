// The nodes without parameters: element by element, and those that move rows. Internal to the graph.
#pragma once

#include "common/nn/graph/graph.h"

namespace dadrl::nn {

class InputNode final : public Node {
 public:
  explicit InputNode(RowShape shape) : Node(shape, {}) {}
  void Forward(const NodePass& /*pass*/) const override {}
  void Backward(const NodePass& /*pass*/) const override {}
};

class ReluNode final : public Node {
 public:
  using Node::Node;
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;
};

class TanhNode final : public Node {
 public:
  using Node::Node;
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;
};

class AddNode final : public Node {
 public:
  using Node::Node;
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;
};

class ConcatNode final : public Node {
 public:
  ConcatNode(Value a, const RowShape& a_shape, Value b, const RowShape& b_shape);
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  RowShape parts_[2];
};

class SelectNode final : public Node {
 public:
  // Row i of the output is row `position` of input `input`.
  struct Source {
    size_t input = 0;
    int position = 0;
    size_t floats = 0;  // of that input, a sample
  };
  SelectNode(std::vector<Value> inputs, std::vector<Source> sources, int features)
      : Node({static_cast<int>(sources.size()), features}, std::move(inputs)), sources_(std::move(sources)) {}
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  std::vector<Source> sources_;
};

class MaxPoolNode final : public Node {
 public:
  MaxPoolNode(const std::vector<Value>& inputs, const RowShape& input_shape, int groups)
      : Node({groups, input_shape.features}, inputs), length_(input_shape.positions / groups) {}
  // Which row each maximum is of; -1 where there is none.
  size_t kept_floats(int batch) const override { return static_cast<size_t>(batch) * shape().floats(); }
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  int length_;  // of a group
};

}  // namespace dadrl::nn
