// The memory of one thread's passes through a graph.
#pragma once

#include <vector>

#include "common/nn/graph/graph.h"

namespace dadrl::nn {

// Laid out in an arena once, for batches of up to `batch` samples. Borrows graph and arena. Not thread safe;
// no pass allocates.
class Tape {
 public:
  Tape() = default;
  // Without `keep` it can only be run forward.
  Tape(Arena& arena, const Graph& graph, int batch, bool keep);

  // [batch][positions][stride]: a graph's input, to be written before Forward, its padding left alone.
  float* input(Value value) { return values_[Index(value)]; }
  const float* value(Value value) const { return values_[Index(value)]; }
  // What its node keeps: attention weights [batch][groups][heads][queries][keys rounded up to sixteen].
  const float* kept(Value value) const { return kept_[Index(value)]; }
  // Of a loss with respect to a trained value: to be written between BeginBackward and Backward.
  float* gradient(Value value) { return gradients_[Index(value)]; }

  void Forward(const float* parameters, int batch);
  // Clears the gradients of all values.
  void BeginBackward();
  // Carries them on to the parameters: `gradients`, in their layout, is added to. After the Forward of the
  // same parameters.
  void Backward(const float* parameters, float* gradients);

 private:
  static size_t Index(Value value) { return static_cast<size_t>(value.index); }
  NodePass PassOf(int node, const float* parameters);

  const Graph* graph_ = nullptr;
  const LaneKernels* lanes_ = nullptr;
  const RowKernels* rows_ = nullptr;
  int batch_ = 0;
  std::vector<float*> values_;
  std::vector<float*> gradients_;  // null where none is wanted
  std::vector<float*> kept_;
  // Of each node's inputs one after the other; a node's begin at first_input_.
  std::vector<size_t> first_input_;
  std::vector<const float*> inputs_;
  std::vector<float*> input_gradients_;
  float* scratch_ = nullptr;
  float* all_gradients_ = nullptr;
  size_t gradient_floats_ = 0;
};

}  // namespace dadrl::nn
