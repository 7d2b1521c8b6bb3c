// A whole update of PPO, two epochs in minibatches, against PyTorch in float64: same start, order and noise.
// As in sac_golden_test.cpp, Adam's epsilon is 1e-5, so that rounding noise moves nothing.
#include "learner/algorithms/ppo/ppo.h"
#include "tests/learner/algorithms/ppo/rollout.h"
#include "tests/learner/algorithms/sac_fixture.h"

namespace dadrl {
namespace {

using golden::ExpectAgrees;
using golden::ExpectTensorsAgree;
using golden::Floats;

constexpr int kTrajectories = 4;
constexpr int kLength = 4;
constexpr size_t kSteps = 13;
constexpr int kEpochs = 2;

Config ConfigOf(EncoderSharing encoders, int threads) {
  Config config = SmallPpo(kTrajectories * kLength, kLength);
  config.model.encoders = encoders;
  config.algorithm.batch_size = 8;
  config.algorithm.epochs = kEpochs;
  config.algorithm.gamma = 0.95;
  config.algorithm.gae_lambda = 0.9;
  config.algorithm.clip_ratio = 0.2;
  config.algorithm.entropy_weight = 0.02;
  config.algorithm.max_gradient_norm = 0.5;
  config.algorithm.adam_epsilon = 1e-5;
  config.algorithm.actor_learning_rate = 3e-4;
  config.algorithm.critic_learning_rate = 3e-4;
  config.learner.threads = threads;
  return config;
}

TrajectoryBatch RolloutOf(const Config& config, const std::string& folder) {
  TrajectoryBatch batch(DrivingStepSpec(config), Ppo::SpecOf(config).batch);
  const auto fill = [](const std::string& name, auto read, auto to) {
    auto values = read("inputs/" + name + "0");
    const auto more = read("inputs/" + name + "1");
    values.insert(values.end(), more.begin(), more.end());
    std::copy_n(values.begin(), to.size(), to.begin());
  };
  fill("vehicles", Floats, VehiclesOf(batch.observations));
  fill("ego", Floats, EgoOf(batch.observations));
  fill("context", golden::Bytes, ContextOf(batch.observations));
  batch.decisions[0] = golden::Uniform(200, batch.decisions[0].size(), 0.99f);
  batch.decisions[1] = Floats(folder + "/log_probability");
  batch.rewards = golden::Uniform(201, batch.rewards.size(), 2.0f);
  batch.steps = {4, 2, 3, 4};
  batch.terminated[1] = 1;
  batch.truncated[2] = 1;
  return batch;
}

void CheckUpdate(const std::string& folder, EncoderSharing encoders, int threads) {
  const Config config = ConfigOf(encoders, threads);
  auto noise = std::make_unique<RecordedNoise>();
  for (uint64_t epoch = 0; epoch < kEpochs; ++epoch) {
    noise->Push(golden::Uniform(210 + epoch, kSteps));
    noise->Push(golden::Uniform(220 + epoch, kSteps * 2, 2.0f));
  }
  Ppo ppo(config, std::move(noise));
  const std::span<float> policy = FloatsOf(ppo, "policy");
  const std::span<float> value = FloatsOf(ppo, "value");
  golden::FillParameters(ppo.policy().layout, 1, policy);
  golden::FillParameters(ppo.value().layout, 2, value);
  size_t first = 0;  // tensor that the policy loss trains
  if (encoders == EncoderSharing::kShared) {
    std::ranges::copy(value.first(ppo.policy().encoder_range.count), policy.begin());
    for (const nn::TensorInfo& tensor : ppo.policy().layout.tensors())
      first += tensor.name.starts_with("encoder.");
  }
  const Status updated = ppo.Update(RolloutOf(config, folder));
  ASSERT_TRUE(updated) << updated.error().message;
  const std::vector<float> scalars = Floats(folder + "/scalars");
  ASSERT_EQ(scalars.size(), ppo.scalars().size());
  for (size_t i = 0; i < scalars.size(); ++i) {
    const auto expected = static_cast<double>(scalars[i]);
    EXPECT_NEAR(ppo.scalars()[i], expected, golden::kTolerance * std::max(1.0, std::abs(expected)))
        << ppo.spec().scalars[i].name;
  }
  ExpectTensorsAgree(ppo.policy().layout, policy, Floats(folder + "/policy"), "policy", first);
  ExpectTensorsAgree(ppo.value().layout, value, Floats(folder + "/value"), "value");
  if (first > 0) {
    const size_t shared = ppo.policy().encoder_range.count;
    EXPECT_TRUE(std::ranges::equal(policy.first(shared), value.first(shared)));
  }
}

class PpoGolden : public testing::TestWithParam<int> {};

TEST_P(PpoGolden, SeparateEncoders) { CheckUpdate("ppo_separate", EncoderSharing::kSeparate, GetParam()); }
TEST_P(PpoGolden, SharedEncoder) { CheckUpdate("ppo_shared", EncoderSharing::kShared, GetParam()); }

INSTANTIATE_TEST_SUITE_P(Threads, PpoGolden, testing::Values(1, 2));

}  // namespace
}  // namespace dadrl
