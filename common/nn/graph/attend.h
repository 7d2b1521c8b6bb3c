// Scaled dot-product attention over projected rows. Internal to the graph.
#pragma once

#include "common/nn/graph/graph.h"

namespace dadrl::nn {

// Inputs: query, key, value, and absent where keys are masked. Each head of each group of each sample is a
// few small products.
class AttendNode final : public Node {
 public:
  AttendNode(const std::vector<Value>& inputs, int query_positions, int key_positions,
             const AttentionShape& attention);
  // The weights, [batch][groups][heads][queries][keys rounded up to sixteen].
  size_t kept_floats(int batch) const override;
  size_t scratch_floats() const override;
  void Forward(const NodePass& pass) const override;
  void Backward(const NodePass& pass) const override;

 private:
  // Where one head of one group of one sample lies.
  struct Head {
    ptrdiff_t query = 0;    // of query and output, in floats
    ptrdiff_t key = 0;      // of key and value
    ptrdiff_t weights = 0;  // of what is kept
    ptrdiff_t absent = 0;
  };
  Head HeadAt(int group, int head) const;  // groups counted over all samples
  template <typename Visit>
  void ForEachHead(const NodePass& pass, Visit visit) const;
  ScoreRows Scores(const NodePass& pass, const Head& head, float* scores) const;
  // scratch = the transpose of a head's keys or values, in blocks of sixteen of them.
  void Transpose(const NodePass& pass, const float* rows) const;
  // c [queries][keys] = a [queries][key_dim] scratch.
  void MultiplyTransposed(const NodePass& pass, const float* a, float* c) const;

  AttentionShape attention_;
  int queries_;  // of a group
  int keys_;
  ptrdiff_t weight_stride_;
};

}  // namespace dadrl::nn
