#include "common/model/decision_transformer_policy.h"

#include <gtest/gtest.h>

#include "common/model/decision_transformer.h"
#include "tests/golden/golden.h"

namespace dadrl {
namespace {

constexpr int kContext = DecisionTransformer::kContext;

class DecisionTransformerPolicyTest : public testing::Test {
 protected:
  DecisionTransformerPolicyTest() {
    std::vector<float> parameters(policy_->layout().size());
    policy_->layout().Initialize(7, parameters);
    EXPECT_TRUE(policy_->Load(parameters));
  }

  // What the policy does on observations `first` to `last`, from a fresh episode.
  std::vector<Action> Drive(int first, int last) {
    policy_->BeginEpisode();
    std::vector<Action> actions;
    for (int i = first; i < last; ++i) actions.push_back(policy_->Act(At(i), nullptr));
    return actions;
  }
  Observation At(int index) const {
    Observation observation(shape_);
    for (size_t column = 0; column < 2; ++column) {
      const std::span<float> to = observation.floats(column);
      std::ranges::copy(golden::Uniform(static_cast<uint64_t>(2 * index) + column, to.size()), to.begin());
    }
    return observation;
  }

  const DrivingShape shape_{.vehicles = 2, .history = 2};
  const std::unique_ptr<PolicyModel> policy_ = MakeDecisionTransformerPolicy(shape_, {}).value();
};

TEST_F(DecisionTransformerPolicyTest, AnEpisodeForgetsTheOneBefore) {
  const std::vector<Action> fresh = Drive(0, 5);
  Drive(50, 60);
  EXPECT_EQ(Drive(0, 5), fresh);
}

TEST_F(DecisionTransformerPolicyTest, WhatWasSeenBeforeMatters) {
  const Action with_history = Drive(0, 5).back();
  const Action without = Drive(4, 5).back();
  EXPECT_NE(with_history, without);
}

TEST_F(DecisionTransformerPolicyTest, NoiseChangesNothing) {
  const Action likeliest = Drive(0, 1).front();
  policy_->BeginEpisode();
  Random random(1);
  EXPECT_EQ(policy_->Act(At(0), &random), likeliest);
}

// Beyond the context the oldest decision is let go of: the network sees the last twenty, from place 0 on.
TEST_F(DecisionTransformerPolicyTest, ALongEpisodeSlidesAlong) {
  const std::vector<Action> actions = Drive(0, kContext + 3);
  const DecisionTransformer network(shape_);
  nn::Arena measure;
  const nn::Tape measured(measure, network.graph, 1, false);
  nn::Arena arena(measure.used());
  nn::Tape tape(arena, network.graph, 1, false);
  FillConstants(network, tape, 1);
  for (int place = 0; place < kContext; ++place) {
    WriteState(network, At(place + 3), 0, tape, 0, place);
    std::ranges::copy(actions[static_cast<size_t>(place + 3)],
                      tape.input(network.actions) + OffsetOf(network, network.actions, 0, place));
  }
  nn::FloatBuffer parameters(network.layout.size());
  network.layout.Initialize(7, parameters.span());
  tape.Forward(parameters.data(), 1);
  const float* const last = tape.value(network.output) + OffsetOf(network, network.output, 0, kContext - 1);
  for (size_t d = 0; d < 2; ++d) EXPECT_NEAR(actions.back()[d], last[d], 1e-6);
}

}  // namespace
}  // namespace dadrl
