// A small network for each kind of node: those of make_graph_golden.py.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "common/nn/graph/tape.h"
#include "tests/golden/golden.h"

namespace dadrl::nn {

constexpr int kCaseBatch = 5;

struct GraphCase {
  // Adds to the layout and to the graph; `fill` comes to hold what to write into which input.
  struct Filled {
    Value input;
    std::vector<float> rows;  // [batch, positions, features]
  };
  std::string name;
  std::function<Value(Graph&, ParamLayout&, std::vector<Filled>&)> build;
};

inline Value Uniform(Graph& graph, std::vector<GraphCase::Filled>& fill, uint64_t salt, int positions,
                     int features) {
  const Value input = graph.Input(positions, features);
  fill.push_back({input, golden::Uniform(salt, static_cast<size_t>(kCaseBatch * positions * features))});
  return input;
}

// The `absent` of make_graph_golden.py.
inline Value Absent(Graph& graph, std::vector<GraphCase::Filled>& fill, int positions) {
  const Value input = graph.Input(positions, 1);
  std::vector<float> mask;
  for (int b = 0; b < kCaseBatch; ++b) {
    for (int i = 0; i < positions; ++i) mask.push_back(b == 3 || (b * 5 + i * 3) % 4 == 0 ? 1.0f : 0.0f);
  }
  fill.push_back({input, mask});
  return input;
}

inline std::vector<GraphCase> GraphCases() {
  using Fill = std::vector<GraphCase::Filled>;
  const auto hidden = [](Graph& g, ParamLayout& l, Fill& f, int positions, int outputs) {
    return g.Dense(l, "hidden", Uniform(g, f, 200, positions, 7), outputs);
  };
  return {
      {"dense",
       [=](Graph& g, ParamLayout& l, Fill& f) { return g.Dense(l, "output", hidden(g, l, f, 3, 21), 5); }},
      {"activations",
       [=](Graph& g, ParamLayout& l, Fill& f) {
         const Value x = hidden(g, l, f, 3, 21);
         return g.Add(g.Relu(x), g.Tanh(x));
       }},
      {"layer_norm",
       [=](Graph& g, ParamLayout& l, Fill& f) { return g.LayerNorm(l, "norm", hidden(g, l, f, 3, 21)); }},
      {"embed",
       [](Graph& g, ParamLayout& l, Fill& f) {
         const Value index = g.Input(3, 1);
         std::vector<float> rows;
         for (int i = 0; i < kCaseBatch * 3; ++i) rows.push_back(static_cast<float>(i * 7 % 13));
         f.push_back({index, rows});
         return g.Embed(l, "table", index, 11, 20);
       }},
      {"structure",
       [=](Graph& g, ParamLayout& l, Fill& f) {
         const Value a = hidden(g, l, f, 3, 9);
         const Value joined = g.Concat(a, g.Dense(l, "b", Uniform(g, f, 201, 3, 4), 13));
         const Value other = g.Dense(l, "other", Uniform(g, f, 202, 2, 5), 22);
         return g.Select({{joined, 2}, {other, 0}, {joined, 0}, {other, 1}, {joined, 2}});
       }},
      {"max_pool",
       [=](Graph& g, ParamLayout& l, Fill& f) {
         const Value x = hidden(g, l, f, 8, 19);
         return g.MaxPool(x, 2, Absent(g, f, 8));
       }},
      {"attention",
       [=](Graph& g, ParamLayout& l, Fill& f) {
         const Value query = hidden(g, l, f, 6, 12);
         const Value keys = g.Dense(l, "keys", Uniform(g, f, 201, 10, 9), 18);
         return g.Attention(l, "attention", query, keys,
                            {.heads = 2, .key_dim = 16, .outputs = 10, .groups = 2}, Absent(g, f, 10));
       }},
      {"causal",
       [=](Graph& g, ParamLayout& l, Fill& f) {
         const Value x = hidden(g, l, f, 20, 16);
         return g.Attention(l, "attention", x, x, {.key_dim = 32, .outputs = 16, .causal = true});
       }},
  };
}

// A case with parameters, inputs and memory, as its golden files were made.
class CaseUnderTest {
 public:
  explicit CaseUnderTest(const GraphCase& c) : output_(c.build(graph_, layout_, fill_)) {
    Arena measure;
    const Tape measured(measure, graph_, kCaseBatch, true);
    arena_ = Arena(measure.used());
    tape_ = Tape(arena_, graph_, kCaseBatch, true);
    parameters_ = FloatBuffer(layout_.size());
    gradients_ = FloatBuffer(layout_.size());
    uint64_t salt = 300;
    for (const TensorInfo& tensor : layout_.tensors()) {
      std::ranges::copy(golden::Uniform(salt++, tensor.size, 0.5f), parameters_.data() + tensor.offset);
    }
    for (const auto& [input, rows] : fill_) Write(input, rows);
    const RowShape& shape = graph_.shape(output_);
    loss_ = golden::Uniform(250, static_cast<size_t>(kCaseBatch * shape.positions * shape.features));
  }

  void Forward() { tape_.Forward(parameters_.data(), kCaseBatch); }
  void Backward() {
    tape_.BeginBackward();
    ForEach([&](size_t at, size_t i) { tape_.gradient(output_)[at] = loss_[i]; });
    tape_.Backward(parameters_.data(), gradients_.data());
  }
  std::vector<float> Output() {
    std::vector<float> rows(loss_.size());
    ForEach([&](size_t at, size_t i) { rows[i] = tape_.value(output_)[at]; });
    return rows;
  }
  double Loss() {
    double sum = 0.0;
    ForEach([&](size_t at, size_t i) {
      sum += static_cast<double>(tape_.value(output_)[at]) * static_cast<double>(loss_[i]);
    });
    return sum;
  }
  const ParamLayout& layout() const { return layout_; }
  std::span<float> parameters() { return parameters_.span(); }
  std::span<const float> gradients() const { return gradients_.span(); }

 private:
  void Write(Value input, const std::vector<float>& rows) {
    const RowShape& shape = graph_.shape(input);
    const auto features = static_cast<size_t>(shape.features);
    for (size_t i = 0; i < rows.size(); ++i) {
      tape_.input(input)[i / features * static_cast<size_t>(shape.stride()) + i % features] = rows[i];
    }
  }
  // Of the output: its place with padding, and without.
  template <typename Visit>
  void ForEach(Visit visit) {
    const RowShape& shape = graph_.shape(output_);
    const auto features = static_cast<size_t>(shape.features);
    for (size_t i = 0; i < loss_.size(); ++i) {
      visit(i / features * static_cast<size_t>(shape.stride()) + i % features, i);
    }
  }

  ParamLayout layout_;
  Graph graph_;
  std::vector<GraphCase::Filled> fill_;
  Value output_;
  Arena arena_;
  Tape tape_;
  FloatBuffer parameters_;
  FloatBuffer gradients_;
  std::vector<float> loss_;
};

}  // namespace dadrl::nn
