// The scene encoder: attention over what vehicles did and where they can go (Liu et al. 2022, "Augmenting
// Reinforcement Learning with Transformer-based Scene Representation Learning", the multi-stage transformer).
#pragma once

#include <span>
#include <string>

#include "common/nn/graph/tape.h"
#include "common/step/driving_shape.h"

namespace dadrl {

// Five stages, each followed by ReLU; heads have 128 key dimensions:
//   1. the rows of each agent's history (the ego's first) attend to each other, two heads; pooled over time
//   2. the points of each way the same; with what it belongs to (ego or vehicle), Dense 128
//   3. each vehicle attends to itself and its two ways, two heads
//   4. the ego attends to itself and the vehicles, two heads
//   5. what came of it attends to the ego's own ways, one head; the sum of 4 and 5 are the features
// Absent rows, points, ways and vehicles are masked.
struct SceneEncoder {
  static constexpr int kFeatures = 128;

  // Requires spec.polylines.
  static SceneEncoder Add(nn::ParamLayout& layout, const std::string& prefix, const DrivingShape& spec);

  DrivingShape spec;
  nn::Graph graph;
  // Inputs; "absent" is 1 where masked.
  nn::Value rows;  // [(1 + vehicles) history, 7]
  nn::Value row_absent;
  nn::Value points;  // [ways 10, 5]
  nn::Value point_absent;
  nn::Value kinds;         // [ways, 2]: of the ego, of a vehicle
  nn::Value local_absent;  // [3 vehicles]: of stage 3, a vehicle and its ways
  nn::Value agent_absent;  // [1 + vehicles]: of stage 4
  nn::Value way_absent;    // [2]: of stage 5
  nn::Value interaction;   // stage 4's weights
  nn::Value features;      // [1, 128]
};

// Writes the inputs of observation `row` as sample `sample` of the tape.
void PackScene(const SceneEncoder& encoder, ColumnRows observations, int row, nn::Tape& tape, int sample);

// How much the ego attended to each vehicle, [vehicles], mean of the heads, of the tape's sample 0.
void SceneAttention(const SceneEncoder& encoder, const nn::Tape& tape, std::span<float> weights);

}  // namespace dadrl
