// Dense layer, embedding and layer norm: the nodes with parameters. Internal to the graph.
#pragma once

#include <optional>
#include <string>

#include "common/nn/graph/node.h"
#include "common/nn/param_layout.h"

namespace dadrl::nn {

class DenseNode final : public Node {
 public:
  DenseNode(ParamLayout& layout, const std::string& name, Value input, const RowShape& input_shape,
            int outputs, bool bias);
  size_t scratch_floats() const override;
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  // Rows of the weight as wide as the output's stride: in place where they are, else a copy in `scratch`.
  const float* WholeRows(const float* weight, float* scratch) const;
  void AddWeightGradient(const NodePass& pass) const;
  void AddInputGradient(const NodePass& pass) const;

  RowShape input_;
  size_t weight_;
  std::optional<size_t> bias_;
};

class EmbedNode final : public Node {
 public:
  EmbedNode(ParamLayout& layout, const std::string& name, Value input, int positions, int rows, int features);
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  size_t RowOf(const NodePass& pass, int position) const;
  int rows_;
  size_t table_;
};

class LayerNormNode final : public Node {
 public:
  LayerNormNode(ParamLayout& layout, const std::string& name, Value input, const RowShape& shape);
  size_t kept_floats(int batch) const override;
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  NormRows RowsOf(const NodePass& pass) const;
  size_t gain_;
  size_t bias_;
};

}  // namespace dadrl::nn
