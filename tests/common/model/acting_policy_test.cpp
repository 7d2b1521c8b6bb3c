#include "common/model/acting_policy.h"

#include <cmath>

#include "tests/common/model/model_fixture.h"

namespace dadrl {
namespace {

std::vector<float> Parameters(const PolicyNetwork& network, uint64_t seed) {
  std::vector<float> parameters(network.layout.size());
  network.layout.Initialize(seed, parameters);
  return parameters;
}

// [samples, 4]: mean and log std of the batched path.
std::vector<float> BatchedOutput(const PolicyNetwork& network, const std::vector<float>& parameters,
                                 EncoderRun& run, int samples) {
  nn::FloatBuffer aligned(parameters.size());
  std::ranges::copy(parameters, aligned.data());
  run.Forward(aligned.data());
  const int blocks = nn::BlocksOf(samples);
  nn::Arena measure;
  MlpActivations(measure, network.head, blocks);
  nn::Arena arena(measure.used());
  const MlpActivations activations(arena, network.head, blocks);
  nn::FloatBuffer output = nn::LaneBuffer(samples, 4);
  MlpForward(nn::LaneKernelsFor(nn::ActiveIsa()), network.head, aligned.data(), run.features(), blocks,
             activations, nn::Contiguous(output.data(), 4));
  return nn::ToRowVector(nn::Contiguous(output.data(), 4), samples, 4);
}

using ActingPolicyTest = ModelOnEveryIsa;

TEST_P(ActingPolicyTest, AgreesWithTheBatchedPath) {
  for (const bool stae : {true, false}) {
    for (const bool context : {true, false}) {
      ModelConfig model;
      model.stae = stae;
      model.context = context;
      model.hidden = 72;  // no multiple of sixteen
      const DrivingShape spec;
      const PolicyNetwork network(spec, model);
      const std::vector<float> parameters = Parameters(network, 4);
      const Columns batch = GoldenObservations(0);
      EncoderRun run(network.encoder, batch, false);
      const std::vector<float> expected = BatchedOutput(network, parameters, run, batch.rows());
      const std::vector<float> attention =
          stae ? nn::ToRowVector(run.activations().stae.attention.weights, batch.rows(), spec.vehicles)
               : std::vector<float>();
      ActingPolicy policy(spec, model);
      ASSERT_TRUE(policy.Load(parameters));
      for (int i = 0; i < batch.rows(); ++i) {
        policy.Act(OneOf(batch, spec, i), nullptr);
        for (size_t d = 0; d < 2; ++d) {
          const size_t at = static_cast<size_t>(i) * 4 + d;
          EXPECT_NEAR(policy.last().mean[d], expected[at], 1e-5) << "sample " << i;
          EXPECT_NEAR(policy.last().log_std[d], expected[at + 2], 1e-5) << "sample " << i;
        }
        ASSERT_EQ(policy.last().attention.size(), stae ? 6u : 0u);
        for (size_t v = 0; v < policy.last().attention.size(); ++v) {
          EXPECT_NEAR(policy.last().attention[v], attention[static_cast<size_t>(i) * 6 + v], 1e-5);
        }
      }
    }
  }
}

TEST_P(ActingPolicyTest, DeterministicIsTanhOfTheMeanAndNoiseFollowsTheSeed) {
  const DrivingShape spec;
  ActingPolicy policy(spec, {});
  ASSERT_TRUE(policy.Load(Parameters(PolicyNetwork(spec, {}), 4)));
  const Observation observation = OneOf(GoldenObservations(0), spec, 2);
  const Action still = policy.Act(observation, nullptr);
  for (size_t d = 0; d < 2; ++d) EXPECT_NEAR(still[d], std::tanh(policy.last().mean[d]), 1e-6);
  EXPECT_EQ(policy.Act(observation, nullptr), still);
  Random first(5);
  Random second(5);
  const Action noisy = policy.Act(observation, &first);
  EXPECT_NE(noisy, still);
  EXPECT_EQ(policy.Act(observation, &second), noisy);
  Random replay(5);
  for (size_t d = 0; d < 2; ++d) {
    const double u = static_cast<double>(policy.last().mean[d]) +
                     std::exp(static_cast<double>(policy.last().log_std[d])) * replay.Normal();
    EXPECT_NEAR(noisy[d], std::tanh(u), 1e-6);
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, ActingPolicyTest, nn::AllIsas(), nn::IsaTestName);

TEST(ActingPolicyLoadTest, RefusesAnotherLengthAndNamesATensorThatIsNotFinite) {
  const DrivingShape spec;
  const PolicyNetwork network(spec, {});
  ActingPolicy policy(spec, {});
  EXPECT_EQ(policy.parameter_count(), network.layout.size());
  EXPECT_EQ(policy.layout_hash(), network.layout.hash());
  std::vector<float> parameters = Parameters(network, 1);
  parameters.pop_back();
  EXPECT_EQ(policy.Load(parameters).error().code, ErrorCode::kInvalidArgument);
  parameters.push_back(0.0f);
  parameters[network.layout.Find("policy.hidden1.weight")->offset + 3] = std::nanf("");
  const Status status = policy.Load(parameters);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
  EXPECT_NE(status.error().message.find("policy.hidden1.weight"), std::string::npos)
      << status.error().message;
}

TEST(ActingPolicyLoadTest, FailedLoadKeepsThePolicyInUse) {
  const DrivingShape spec;
  const PolicyNetwork network(spec, {});
  ActingPolicy policy(spec, {});
  std::vector<float> parameters = Parameters(network, 1);
  ASSERT_TRUE(policy.Load(parameters));
  const Observation observation = OneOf(GoldenObservations(0), spec, 1);
  const Action before = policy.Act(observation, nullptr);
  for (float& p : parameters) p *= 0.5f;
  parameters.front() = HUGE_VALF;
  ASSERT_FALSE(policy.Load(parameters));
  EXPECT_EQ(policy.Act(observation, nullptr), before);
}

TEST(ActingPolicyLoadTest, LayoutsDifferBetweenModels) {
  ModelConfig blind;
  blind.context = false;
  EXPECT_NE(ActingPolicy(DrivingShape{}, {}).layout_hash(),
            ActingPolicy(DrivingShape{}, blind).layout_hash());
}

}  // namespace
}  // namespace dadrl
