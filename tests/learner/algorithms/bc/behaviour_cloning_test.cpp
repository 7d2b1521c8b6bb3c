#include "learner/algorithms/bc/behaviour_cloning.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/step/driving_shape.h"
#include "tests/golden/golden.h"
#include "tests/learner/algorithms/state_blocks.h"

namespace dadrl {
namespace {

constexpr int kBatch = 48;

Config SmallConfig(int threads = 1) {
  Config config;
  config.algorithm.name = "bc";
  config.algorithm.batch_size = kBatch;
  config.model.hidden = 48;
  config.learner.threads = threads;
  return config;
}

// Observations and actions of a salt.
TrajectoryBatch AnyBatch(int size, uint64_t salt) {
  TrajectoryBatch batch(DrivingShape{}, {.count = size});
  for (size_t column = 0; column < batch.observations.columns(); ++column) {
    const std::span<float> floats = batch.observations.floats(column);
    std::ranges::copy(golden::Uniform(salt++, floats.size()), floats.begin());
    const std::span<uint8_t> bits = batch.observations.bits(column);
    std::ranges::transform(golden::Uniform(salt++, bits.size(), 128.0f), bits.begin(),
                           [](float value) { return static_cast<uint8_t>(value + 128.0f); });
  }
  std::ranges::copy(golden::Uniform(salt, batch.decisions[0].size()), batch.decisions[0].begin());
  std::ranges::fill(batch.steps, 1);
  return batch;
}

double LossAfter(BehaviourCloning& cloning, const TrajectoryBatch& batch) {
  EXPECT_TRUE(cloning.Update(batch));
  return cloning.scalars()[0];
}

TEST(BehaviourCloning, DoesWhatWasDone) {
  BehaviourCloning cloning(SmallConfig());
  const TrajectoryBatch batch = AnyBatch(kBatch, 5);
  const double before = LossAfter(cloning, batch);
  for (int i = 0; i < 150; ++i) ASSERT_TRUE(cloning.Update(batch));
  EXPECT_LT(cloning.scalars()[0], 0.05 * before);
}

// The first moments after one update are a tenth of the gradient.
TEST(BehaviourCloning, ItsGradientAgreesWithFiniteDifferencesOfItsLoss) {
  Config config = SmallConfig();
  config.model.context = false;
  BehaviourCloning cloning(config);
  const TrajectoryBatch batch = AnyBatch(17, 9);  // padding counts for nothing
  const std::vector<std::byte> start = Snapshot(cloning);
  ASSERT_TRUE(cloning.Update(batch));
  const std::span<const float> moments = FloatsOf(cloning, "policy.adam_first");
  std::vector<float> gradient(moments.begin(), moments.end());
  double square = 0.0;
  for (float& g : gradient) {
    g *= 10.0f;
    square += static_cast<double>(g) * static_cast<double>(g);
  }
  // Along the gradient, where the slope is its length.
  const double length = std::sqrt(square);
  constexpr double kStep = 1e-3;
  double loss[2] = {};
  for (const int side : {0, 1}) {
    Restore(cloning, start);
    const std::span<float> parameters = FloatsOf(cloning, "policy");
    const auto step = static_cast<float>((side == 0 ? -kStep : kStep) / length);
    for (size_t i = 0; i < parameters.size(); ++i) parameters[i] += step * gradient[i];
    loss[side] = LossAfter(cloning, batch);
  }
  EXPECT_NEAR((loss[1] - loss[0]) / (2.0 * kStep), length, 0.01 * length);
}

TEST(BehaviourCloning, SameSeedGivesTheSameBitsAndARestoredStateGoesOn) {
  for (const int threads : {1, 2, 3}) {
    BehaviourCloning first(SmallConfig(threads));
    BehaviourCloning second(SmallConfig(threads));
    for (uint64_t i = 0; i < 3; ++i) ASSERT_TRUE(first.Update(AnyBatch(kBatch, 100 * i)));
    const std::vector<std::byte> saved = Snapshot(first);
    Restore(second, saved);
    ASSERT_TRUE(first.Update(AnyBatch(kBatch, 7)));
    ASSERT_TRUE(second.Update(AnyBatch(kBatch, 7)));
    EXPECT_EQ(Snapshot(first), Snapshot(second)) << threads << " threads";
  }
}

TEST(BehaviourCloning, ANumberThatIsNoneIsNamedAndChangesNothing) {
  BehaviourCloning cloning(SmallConfig());
  const std::vector<std::byte> before = Snapshot(cloning);
  TrajectoryBatch batch = AnyBatch(kBatch, 5);
  batch.decisions[0][3] = std::nanf("");
  const Status updated = cloning.Update(batch);
  ASSERT_FALSE(updated);
  EXPECT_NE(updated.error().message.find("action error is not finite in update 1"), std::string::npos);
  EXPECT_EQ(Snapshot(cloning), before);
}

}  // namespace
}  // namespace dadrl
