#include "learner/algorithms/slt/latent_prediction.h"

#include <cmath>

#include "common/step/driving_shape.h"

namespace dadrl {
namespace {

constexpr int kActionUnits = 64;
constexpr int kInnerUnits = 256;

nn::Value Rows(nn::Graph& graph, nn::Value value, int first, int count) {
  std::vector<nn::Position> rows;
  for (int i = 0; i < count; ++i) rows.push_back({value, first + i});
  return graph.Select(rows);
}

}  // namespace

LatentPrediction::LatentPrediction(int latent_features, int steps) {
  latents = graph.Input(steps, latent_features, true);
  actions = graph.Input(steps, kActionSize);
  next = graph.Input(steps, latent_features);
  const nn::Value acted =
      graph.Concat(latents, graph.Relu(graph.Dense(layout, "action", actions, kActionUnits)));
  const nn::Value attended = graph.Attention(layout, "attention", acted, acted,
                                             {.key_dim = kUnits, .outputs = latent_features, .causal = true});
  std::vector<nn::Position> rows;
  for (const nn::Value value : {attended, next}) {
    for (int i = 0; i < steps; ++i) rows.push_back({value, i});
  }
  const nn::Value inner = graph.Relu(graph.Dense(layout, "projector1", graph.Select(rows), kInnerUnits));
  const nn::Value projected = graph.Relu(graph.Dense(layout, "projector2", inner, kUnits));
  prediction = graph.Dense(layout, "predictor", Rows(graph, projected, 0, steps), kUnits);
  target = Rows(graph, projected, steps, steps);
}

double NegativeCosine(std::span<const float> prediction, std::span<const float> target, double scale,
                      std::span<float> gradient) {
  double product = 0.0;
  double predicted = 0.0;
  double wanted = 0.0;
  for (size_t i = 0; i < prediction.size(); ++i) {
    const double p = prediction[i];
    const double t = target[i];
    product += p * t;
    predicted += p * p;
    wanted += t * t;
  }
  const double lengths = std::sqrt(predicted * wanted);
  if (lengths == 0.0) return 0.0;
  for (size_t i = 0; i < prediction.size(); ++i) {
    const double p = prediction[i];
    const double t = target[i];
    gradient[i] = static_cast<float>(scale * (product * p / predicted - t) / lengths);
  }
  return -scale * product / lengths;
}

}  // namespace dadrl
