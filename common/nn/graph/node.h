// One operation of a graph: what each kind of node implements.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/nn/aligned_buffer.h"
#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/rows/row_kernels.h"

namespace dadrl::nn {

// What a node puts out for a batch: [batch][positions][features], each row padded with zeros to a stride of a
// multiple of sixteen.
struct RowShape {
  int positions = 1;
  int features = 1;

  ptrdiff_t stride() const {
    return static_cast<ptrdiff_t>(RoundUp(static_cast<size_t>(features), kAlignedFloats));
  }
  // Floats of one sample.
  size_t floats() const { return static_cast<size_t>(positions * stride()); }
  bool operator==(const RowShape&) const = default;
};

// A node's output, by its place in the graph.
struct Value {
  int index = -1;
};

// A pass over a batch, as one node sees it. Lent.
struct NodePass {
  const LaneKernels& lanes;
  const RowKernels& rows;
  int batch = 0;
  const float* parameters = nullptr;
  float* gradients = nullptr;               // of the parameters, added to; backward only
  std::span<const float* const> inputs;     // in the order of Node::inputs
  std::span<float* const> input_gradients;  // added to; null where nobody wants it; backward only
  float* output = nullptr;                  // written forward, read backward
  const float* output_gradient = nullptr;   // backward only
  float* kept = nullptr;                    // from forward to backward
  float* scratch = nullptr;                 // for the length of a call
};

// Immutable: any number of threads may run it, each with memory of its own. Allocates nothing in a pass.
class Node {
 public:
  Node(RowShape shape, std::vector<Value> inputs) : shape_(shape), inputs_(std::move(inputs)) {}
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  const RowShape& shape() const { return shape_; }
  std::span<const Value> inputs() const { return inputs_; }

  // Of a batch.
  virtual size_t kept_floats(int /*batch*/) const { return 0; }
  virtual size_t scratch_floats() const { return 0; }

  virtual void Forward(const NodePass& pass) const = 0;
  virtual void Backward(const NodePass& pass) const = 0;

 protected:
  int Rows(const NodePass& pass) const { return pass.batch * shape_.positions; }
  size_t Floats(const NodePass& pass) const { return static_cast<size_t>(pass.batch) * shape_.floats(); }

 private:
  RowShape shape_;
  std::vector<Value> inputs_;
};

}  // namespace dadrl::nn
