// The network of the decision transformer (Chen et al. 2021): what is done next, from what was seen and done
// before and the return that is asked for.
#pragma once

#include "common/nn/graph/tape.h"
#include "common/step/driving_shape.h"

namespace dadrl {

// Tokens (return to go, state, action) of up to kContext decisions, the oldest first, each embedded by a
// Dense layer of its own, with a learned embedding of its place in the context added, and layer norm; three
// blocks of x + attention(norm x), x + mlp(norm x), causal, one head, ReLU inside; layer norm; the action is
// tanh of a Dense layer of each state's token. A state is the newest row of the ego and of each vehicle.
struct DecisionTransformer {
  static constexpr int kContext = 20;  // decisions
  static constexpr int kUnits = 128;
  static constexpr int kBlocks = 3;
  static constexpr int kInnerUnits = 512;
  // To-go of every step of a success, whose reward is 1 at the goal and 0 before: what it is trained on and
  // asked for.
  static constexpr float kSuccess = 1.0f;

  explicit DecisionTransformer(const DrivingShape& spec);

  DrivingShape spec;
  nn::ParamLayout layout;
  nn::Graph graph;
  // Inputs, [kContext, .] each; what stands behind the newest decision does not matter.
  nn::Value returns;  // [1]
  nn::Value states;   // [state_features()]
  nn::Value actions;  // [2]
  nn::Value places;   // [1]: 0, 1, 2, ...
  nn::Value output;   // [kContext, 2], in (-1, 1)

  int state_features() const {
    return DrivingShape::kEgoFeatures + spec.vehicles * DrivingShape::kVehicleFeatures;
  }
};

// Writes what does not change, for samples [0, batch).
void FillConstants(const DecisionTransformer& network, nn::Tape& tape, int batch);

// Writes the state of observation `row` as decision `place` of sample `sample`.
void WriteState(const DecisionTransformer& network, ColumnRows observations, int row, nn::Tape& tape,
                int sample, int place);

// Where decision `place` of sample `sample` begins in a value of the network.
size_t OffsetOf(const DecisionTransformer& network, nn::Value value, int sample, int place);

}  // namespace dadrl
