#include "common/model/scene_encoder.h"

#include <algorithm>

namespace dadrl {
namespace {

using nn::AttentionShape;
using nn::Graph;
using nn::ParamLayout;
using nn::Value;

constexpr int kKeyDim = 128;
constexpr int kWayUnits = 192;
constexpr int kKindUnits = 64;
constexpr int kPoints = DrivingShape::kWayPoints;
constexpr int kWays = DrivingShape::kWays;

// Each vehicle with its ways, for stage 3, whose queries are the vehicles.
Value LocalKeys(Graph& graph, Value agents, Value ways, int vehicles) {
  std::vector<nn::Position> keys;
  for (int v = 1; v <= vehicles; ++v) {
    keys.push_back({agents, v});
    for (int way = 0; way < kWays; ++way) keys.push_back({ways, kWays * v + way});
  }
  return graph.Select(keys);
}

Value Vehicles(Graph& graph, Value agents, int vehicles) {
  std::vector<nn::Position> rows;
  for (int v = 1; v <= vehicles; ++v) rows.push_back({agents, v});
  return graph.Select(rows);
}

Value EgoAndVehicles(Graph& graph, Value ego, Value vehicles, int count) {
  std::vector<nn::Position> rows = {{ego, 0}};
  for (int v = 0; v < count; ++v) rows.push_back({vehicles, v});
  return graph.Select(rows);
}

void AddInputs(SceneEncoder& e) {
  const int agents = 1 + e.spec.vehicles;
  e.rows = e.graph.Input(agents * e.spec.history, DrivingShape::kVehicleFeatures);
  e.row_absent = e.graph.Input(agents * e.spec.history, 1);
  e.points = e.graph.Input(e.spec.ways() * kPoints, DrivingShape::kPointFeatures);
  e.point_absent = e.graph.Input(e.spec.ways() * kPoints, 1);
  e.kinds = e.graph.Input(e.spec.ways(), 2);
  e.local_absent = e.graph.Input((1 + kWays) * e.spec.vehicles, 1);
  e.agent_absent = e.graph.Input(agents, 1);
  e.way_absent = e.graph.Input(kWays, 1);
}

// Copies rows of `features` into a graph's input, whose rows are `stride` apart.
void CopyRows(std::span<const float> from, size_t features, float* to) {
  const auto stride = static_cast<ptrdiff_t>(nn::RoundUp(features, nn::kAlignedFloats));
  for (; !from.empty(); from = from.subspan(features), to += stride) {
    std::ranges::copy(from.first(features), to);
  }
}

// The first feature of each row says whether it is absent.
void CopyFlags(const float* rows, ptrdiff_t stride, int count, float* flags) {
  for (int i = 0; i < count; ++i) flags[ptrdiff_t{i} * nn::kLanes] = rows[i * stride];
}

}  // namespace

SceneEncoder SceneEncoder::Add(ParamLayout& layout, const std::string& prefix, const DrivingShape& spec) {
  SceneEncoder e;
  e.spec = spec;
  AddInputs(e);
  Graph& graph = e.graph;
  const int vehicles = spec.vehicles;
  const auto attend = [&](const char* name, Value query, Value keys, const AttentionShape& shape,
                          Value absent) {
    return graph.Relu(graph.Attention(layout, prefix + name, query, keys, shape, absent));
  };
  const AttentionShape two_heads{.heads = 2, .key_dim = kKeyDim, .outputs = kFeatures};
  AttentionShape shape = two_heads;
  shape.groups = 1 + vehicles;
  const Value histories = attend(".time", e.rows, e.rows, shape, e.row_absent);
  const Value agents = graph.MaxPool(histories, 1 + vehicles, e.row_absent);

  shape.groups = spec.ways();
  shape.outputs = kWayUnits;
  const Value along = attend(".points", e.points, e.points, shape, e.point_absent);
  const Value kinds = graph.Relu(graph.Dense(layout, prefix + ".kind", e.kinds, kKindUnits));
  const Value joined = graph.Concat(graph.MaxPool(along, spec.ways(), e.point_absent), kinds);
  const Value ways = graph.Relu(graph.Dense(layout, prefix + ".way", joined, kFeatures));

  shape = two_heads;
  shape.groups = vehicles;
  const Value fused = attend(".local", Vehicles(graph, agents, vehicles),
                             LocalKeys(graph, agents, ways, vehicles), shape, e.local_absent);

  const Value ego = graph.Select({{agents, 0}});
  const Value around =
      attend(".interaction", ego, EgoAndVehicles(graph, ego, fused, vehicles), two_heads, e.agent_absent);
  // Relu, Dense and before it the weights: Graph::Attention appends them last.
  e.interaction = {around.index - 2};
  const Value own_ways = graph.Select({{ways, 0}, {ways, 1}});
  const Value goal =
      attend(".goal", around, own_ways, {.key_dim = kKeyDim, .outputs = kFeatures}, e.way_absent);
  e.features = graph.Add(around, goal);
  return e;
}

void PackScene(const SceneEncoder& encoder, ColumnRows observations, int row, nn::Tape& tape, int sample) {
  const DrivingShape& spec = encoder.spec;
  const auto of = [&](size_t column, int floats) {
    return observations.floats(column).subspan(static_cast<size_t>(row * floats),
                                               static_cast<size_t>(floats));
  };
  const auto at = [&](Value input) {
    return tape.input(input) + static_cast<size_t>(sample) * encoder.graph.shape(input).floats();
  };
  const std::span<const float> ego = of(spec.ego_column, spec.ego_floats());
  float* const rows = at(encoder.rows);
  constexpr ptrdiff_t kStride = nn::kLanes;  // of rows and points
  for (int t = 0; t < spec.history; ++t) {
    std::copy_n(ego.data() + ptrdiff_t{t} * DrivingShape::kEgoFeatures, DrivingShape::kVehicleFeatures,
                rows + t * kStride);
  }
  CopyRows(of(spec.vehicles_column, spec.vehicle_floats()), DrivingShape::kVehicleFeatures,
           rows + spec.history * kStride);
  float* const points = at(encoder.points);
  CopyRows(of(spec.polylines_column, spec.polyline_floats()), DrivingShape::kPointFeatures, points);

  CopyFlags(rows, kStride, (1 + spec.vehicles) * spec.history, at(encoder.row_absent));
  CopyFlags(points, kStride, spec.ways() * kPoints, at(encoder.point_absent));
  CopyFlags(points, kPoints * kStride, kWays, at(encoder.way_absent));
  for (int way = 0; way < spec.ways(); ++way) at(encoder.kinds)[way * kStride + (way < kWays ? 0 : 1)] = 1.0f;
  float* const agent_absent = at(encoder.agent_absent);
  float* const local_absent = at(encoder.local_absent);
  for (int v = 0; v < spec.vehicles; ++v) {
    const float gone = rows[((v + 2) * spec.history - 1) * kStride];  // its newest row
    agent_absent[(1 + v) * kStride] = gone;
    float* const local = local_absent + (1 + kWays) * v * kStride;
    local[0] = gone;
    CopyFlags(points + kWays * (1 + v) * kPoints * kStride, kPoints * kStride, kWays, local + kStride);
  }
}

void SceneAttention(const SceneEncoder& encoder, const nn::Tape& tape, std::span<float> weights) {
  const auto stride = static_cast<size_t>(nn::RoundUp(1 + weights.size(), nn::kAlignedFloats));
  const float* const kept = tape.kept(encoder.interaction);
  for (size_t v = 0; v < weights.size(); ++v) weights[v] = 0.5f * (kept[1 + v] + kept[stride + 1 + v]);
}

}  // namespace dadrl
