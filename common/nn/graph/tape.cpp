#include "common/nn/graph/tape.h"

#include <algorithm>

namespace dadrl::nn {

Tape::Tape(Arena& arena, const Graph& graph, int batch, bool keep)
    : graph_(&graph), lanes_(&LaneKernelsFor(ActiveIsa())), rows_(&RowKernelsFor(ActiveIsa())) {
  const auto samples = static_cast<size_t>(batch);
  size_t scratch = 0;
  for (Value value{0}; value.index < graph.size(); ++value.index) {
    const Node& node = graph.node(value);
    values_.push_back(arena.Allocate(samples * node.shape().floats()));
    kept_.push_back(arena.Allocate(node.kept_floats(batch)));
    scratch = std::max(scratch, node.scratch_floats());
    if (keep && graph.trained(value)) gradient_floats_ += samples * node.shape().floats();
  }
  scratch_ = arena.Allocate(scratch);
  all_gradients_ = arena.Allocate(gradient_floats_);
  size_t at = 0;
  for (Value value{0}; value.index < graph.size(); ++value.index) {
    const bool wanted = keep && graph.trained(value);
    gradients_.push_back(wanted && all_gradients_ != nullptr ? all_gradients_ + at : nullptr);
    if (wanted) at += samples * graph.shape(value).floats();
    first_input_.push_back(inputs_.size());
    for (const Value input : graph.node(value).inputs()) {
      inputs_.push_back(values_[Index(input)]);
      input_gradients_.push_back(gradients_[Index(input)]);
    }
  }
  first_input_.push_back(inputs_.size());
}

NodePass Tape::PassOf(int node, const float* parameters) {
  const auto index = static_cast<size_t>(node);
  const size_t first = first_input_[index];
  const size_t count = first_input_[index + 1] - first;
  return {.lanes = *lanes_,
          .rows = *rows_,
          .batch = batch_,
          .parameters = parameters,
          .inputs = std::span(inputs_).subspan(first, count),
          .input_gradients = std::span(input_gradients_).subspan(first, count),
          .output = values_[index],
          .output_gradient = gradients_[index],
          .kept = kept_[index],
          .scratch = scratch_};
}

void Tape::Forward(const float* parameters, int batch) {
  batch_ = batch;
  for (int i = 0; i < graph_->size(); ++i) graph_->node({i}).Forward(PassOf(i, parameters));
}

void Tape::BeginBackward() { std::fill_n(all_gradients_, gradient_floats_, 0.0f); }

void Tape::Backward(const float* parameters, float* gradients) {
  for (int i = graph_->size(); i-- > 0;) {
    if (gradients_[static_cast<size_t>(i)] == nullptr) continue;
    NodePass pass = PassOf(i, parameters);
    pass.gradients = gradients;
    graph_->node({i}).Backward(pass);
  }
}

}  // namespace dadrl::nn
