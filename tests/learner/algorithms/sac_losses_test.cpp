// The losses against PyTorch in float64, and n-step targets against a table worked by hand.
#include "learner/algorithms/sac_losses.h"

#include <cmath>

#include "tests/common/nn/lane_test.h"
#include "tests/golden/golden.h"
#include "tests/learner/algorithms/sac_fixture.h"

namespace dadrl {
namespace {

using golden::ExpectAgrees;
using golden::Floats;
using golden::Uniform;

constexpr int kBatch = 18;

// A workspace for one thread, with networks of no importance.
class SacLossesTest : public testing::Test {
 protected:
  SacLossesTest() : policy_({}, Model()), critic_({}, Model()) {
    nn::Arena measure;
    SacWorkspace(measure, policy_, critic_, {}, 2, 1);
    arena_ = nn::Arena(measure.used());
    workspace_ = std::make_unique<SacWorkspace>(arena_, policy_, critic_, DrivingShape{}, 2, 1);
    workspace_->samples = kBatch;
  }

  static ModelConfig Model() {
    ModelConfig model;
    model.stae = model.context = false;
    model.hidden = 16;
    return model;
  }

  static void Write(nn::LaneSpan span, int features, const std::vector<float>& rows) {
    for (int i = 0; i < kBatch; ++i) {
      for (int f = 0; f < features; ++f) {
        span.block(i / nn::kLanes)[f * nn::kLanes + i % nn::kLanes] =
            rows[static_cast<size_t>(i * features + f)];
      }
    }
  }
  static std::vector<float> Read(nn::LaneSpan span, int features) {
    return nn::ToRowVector(span, kBatch, features);
  }

  PolicyNetwork policy_;
  CriticNetwork critic_;
  nn::Arena arena_;
  std::unique_ptr<SacWorkspace> workspace_;
};

constexpr double kAlpha = 0.25;
constexpr nn::GaussianLimits kLimits{-2.0, 1.5};

TEST_F(SacLossesTest, AllLossesAgreeWithPyTorch) {
  SacWorkspace& w = *workspace_;
  const std::vector<float> noise = Uniform(81, kBatch * 2, 2.0f);
  Write(w.policy_output, 4, Uniform(80, kBatch * 4, 3.0f));
  const int features = critic_.encoder.features();
  SampleActions(w, kLimits, noise, w.critic_input, features);
  const std::vector<float> action = Read(w.critic_input.From(features), 2);
  ExpectAgrees(action, Floats("losses/action"), "action");
  ExpectAgrees(
      std::vector<float>(w.actions.log_probability.begin(), w.actions.log_probability.begin() + kBatch),
      Floats("losses/log_probability"), "log probability");

  const std::vector<float> slopes[2] = {Uniform(82, kBatch * 2), Uniform(83, kBatch * 2)};
  SacWorkspace::Critic* const critics[2] = {&w.critic1, &w.critic2};
  for (int c = 0; c < 2; ++c) {
    std::vector<float> q;
    for (size_t i = 0; i < kBatch; ++i) {
      q.push_back(slopes[c][2 * i] * action[2 * i] + slopes[c][2 * i + 1] * action[2 * i + 1]);
    }
    Write(critics[c]->value, 1, q);
  }

  TransitionBatch batch(DrivingShape{}, kBatch);
  batch.reward = Uniform(84, kBatch);
  batch.weight = Uniform(85, kBatch);
  batch.discount = Uniform(86, kBatch);
  for (size_t i = 0; i < kBatch; ++i) {
    batch.weight[i] = std::abs(batch.weight[i]);
    batch.discount[i] = i % 5 == 0 ? 0.0f : std::abs(batch.discount[i]);
  }
  ComputeTargets(w, batch, {}, kAlpha);
  ExpectAgrees(std::span(w.targets).first(kBatch), Floats("losses/target"), "target");

  w.sums = {};
  ActorValueGradient(w, kBatch, kAlpha);
  EXPECT_NEAR(w.sums.actor / kBatch, static_cast<double>(Floats("losses/actor_loss").at(0)), 1e-6);
  for (int c = 0; c < 2; ++c) {
    std::vector<float> action_gradient = Read(critics[c]->value_gradient, 1);
    std::vector<float> rows;
    for (size_t i = 0; i < kBatch * 2; ++i) rows.push_back(action_gradient[i / 2] * slopes[c][i]);
    Write(critics[c]->action_gradient, 2, rows);
  }
  ActorOutputGradient(w, kBatch, kAlpha, noise);
  ExpectAgrees(Read(w.policy_output_gradient, 4), Floats("losses/actor_gradient"), "policy output");

  Write(w.critic1.value, 1, Uniform(87, kBatch));
  Write(w.critic2.value, 1, Uniform(88, kBatch));
  std::vector<float> td_error(kBatch);
  CriticLoss(w, batch, {}, td_error);
  EXPECT_NEAR((w.sums.weighted_squares1 + w.sums.weighted_squares2) / kBatch,
              static_cast<double>(Floats("losses/critic_loss").at(0)), 1e-6);
  ExpectAgrees(Read(w.critic1.value_gradient, 1), Floats("losses/value1_gradient"), "value 1");
  ExpectAgrees(Read(w.critic2.value_gradient, 1), Floats("losses/value2_gradient"), "value 2");
}

TEST_F(SacLossesTest, PaddingGetsNoGradient) {
  SacWorkspace& w = *workspace_;
  for (nn::LaneSpan span : {w.critic1.value_gradient, w.critic2.value_gradient}) {
    std::fill(span.data, span.data + 2 * nn::kLanes, 7.0f);
  }
  TransitionBatch batch(DrivingShape{}, kBatch);
  std::vector<float> td_error(kBatch);
  CriticLoss(w, batch, {}, td_error);
  for (nn::LaneSpan span : {w.critic1.value_gradient, w.critic2.value_gradient}) {
    for (int lane = kBatch % nn::kLanes; lane < nn::kLanes; ++lane) EXPECT_EQ(span.block(1)[lane], 0.0f);
  }
}

// gamma 0.9, n = 3, alpha 0.5, min Q' = 2 and log pi' = -1 everywhere, so a bootstrap is worth 2.5.
TEST_F(SacLossesTest, NStepTargetsMatchAHandWorkedTable) {
  SacWorkspace& w = *workspace_;
  struct Row {
    const char* what;
    float reward;    // sum of 0.9^i r_i
    float discount;  // 0.9^k, or 0
    double target;
  };
  const Row rows[] = {
      {"three steps of 1: 1 + 0.9 + 0.81, then 0.729 * 2.5", 2.71f, 0.729f, 4.5325},
      {"terminated in its second step with 3: 1 + 0.9 * 3", 3.7f, 0.0f, 3.7},
      {"truncated after two steps of 1: 1.9 + 0.81 * 2.5", 1.9f, 0.81f, 3.925},
      {"truncated after one step of -1: -1 + 0.9 * 2.5", -1.0f, 0.9f, 1.25},
      {"terminated at once with -1", -1.0f, 0.0f, -1.0},
  };
  TransitionBatch batch(DrivingShape{}, kBatch);
  for (size_t i = 0; i < std::size(rows); ++i) {
    batch.reward[i] = rows[i].reward;
    batch.discount[i] = rows[i].discount;
  }
  Write(w.critic1.value, 1, std::vector<float>(kBatch, 5.0f));
  Write(w.critic2.value, 1, std::vector<float>(kBatch, 2.0f));
  std::ranges::fill(w.actions.log_probability, -1.0);
  ComputeTargets(w, batch, {}, 0.5);
  for (size_t i = 0; i < std::size(rows); ++i)
    EXPECT_NEAR(w.targets[i], rows[i].target, 1e-6) << rows[i].what;
}

TEST_F(SacLossesTest, NanInEitherCriticReachesTargetAndLoss) {
  SacWorkspace& w = *workspace_;
  TransitionBatch batch(DrivingShape{}, kBatch);
  std::ranges::fill(batch.discount, 0.9f);
  for (SacWorkspace::Critic* critic : {&w.critic1, &w.critic2}) {
    Write(w.critic1.value, 1, std::vector<float>(kBatch, 1.0f));
    Write(w.critic2.value, 1, std::vector<float>(kBatch, 1.0f));
    std::vector<float> values(kBatch, 2.0f);
    values[4] = std::nanf("");
    Write(critic->value, 1, values);
    ComputeTargets(w, batch, {}, 0.1);
    EXPECT_TRUE(std::isnan(w.targets[4]));
    w.sums = {};
    ActorValueGradient(w, kBatch, 0.1);
    EXPECT_TRUE(std::isnan(w.sums.actor));
  }
}

}  // namespace
}  // namespace dadrl
