#include "common/model/squashed_gaussian_policy.h"

#include <cmath>
#include <numbers>

#include "tests/common/model/model_fixture.h"

namespace dadrl {
namespace {

std::vector<float> Parameters(const PolicyNetwork& network, uint64_t seed) {
  std::vector<float> parameters(network.layout.size());
  network.layout.Initialize(seed, parameters);
  return parameters;
}

class SquashedGaussianTest : public ModelOnEveryIsa {
 protected:
  static std::unique_ptr<PolicyModel> Loaded() {
    const DrivingShape spec;
    std::unique_ptr<PolicyModel> policy = MakeSquashedGaussianPolicy(spec, {}).value();
    EXPECT_TRUE(policy->Load(Parameters(PolicyNetwork(spec, {}), 4)));
    return policy;
  }
};

TEST_P(SquashedGaussianTest, AgreesWithTheBatchedPath) {
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
      const auto policy = MakeSquashedGaussianPolicy(spec, model).value();
      ASSERT_TRUE(policy->Load(parameters));
      const PolicyModel::Details& details = policy->last();
      for (int i = 0; i < batch.rows(); ++i) {
        policy->Act(OneOf(batch, spec, i), nullptr);
        for (size_t d = 0; d < 2; ++d) {
          const size_t at = static_cast<size_t>(i) * 4 + d;
          EXPECT_NEAR(details.Find("mean")[d], expected[at], 1e-5) << "sample " << i;
          EXPECT_NEAR(details.Find("log_std")[d], expected[at + 2], 1e-5) << "sample " << i;
        }
        ASSERT_EQ(details.attention.size(), stae ? 6u : 0u);
        for (size_t v = 0; v < details.attention.size(); ++v) {
          EXPECT_NEAR(details.attention[v], attention[static_cast<size_t>(i) * 6 + v], 1e-5);
        }
      }
    }
  }
}

TEST_P(SquashedGaussianTest, LikeliestIsTanhOfTheMeanAndNoiseFollowsTheSeed) {
  const auto policy = Loaded();
  const Observation observation = OneOf(GoldenObservations(0), DrivingShape{}, 2);
  const Action still = policy->Act(observation, nullptr);
  const std::span<const float> mean = policy->last().Find("mean");
  const std::span<const float> log_std = policy->last().Find("log_std");
  for (size_t d = 0; d < 2; ++d) EXPECT_NEAR(still[d], std::tanh(mean[d]), 1e-6);
  EXPECT_FALSE(policy->last().log_probability);
  EXPECT_EQ(policy->Act(observation, nullptr), still);
  Random first(5);
  Random second(5);
  const Action noisy = policy->Act(observation, &first);
  EXPECT_NE(noisy, still);
  EXPECT_EQ(policy->Act(observation, &second), noisy);
  Random replay(5);
  for (size_t d = 0; d < 2; ++d) {
    const double u =
        static_cast<double>(mean[d]) + std::exp(static_cast<double>(log_std[d])) * replay.Normal();
    EXPECT_NEAR(noisy[d], std::tanh(u), 1e-6);
  }
}

// log N(atanh a; mean, std) - log(1 - a^2), summed over both: of the action alone, not of the noise behind
// it.
TEST_P(SquashedGaussianTest, LogProbabilityIsTheDensityOfTheSampledAction) {
  const auto policy = Loaded();
  const Columns batch = GoldenObservations(0);
  Random random(7);
  for (int i = 0; i < 40; ++i) {
    const Action action = policy->Act(OneOf(batch, DrivingShape{}, i % batch.rows()), &random);
    double expected = 0.0;
    double sensitivity = 0.0;  // to the rounding of an action to float32
    for (size_t d = 0; d < 2; ++d) {
      const double a = action[d];
      const double std = std::exp(static_cast<double>(policy->last().Find("log_std")[d]));
      const double noise = (std::atanh(a) - static_cast<double>(policy->last().Find("mean")[d])) / std;
      expected +=
          -0.5 * noise * noise - std::log(std * std::sqrt(2.0 * std::numbers::pi)) - std::log1p(-a * a);
      sensitivity += (std::abs(noise) / std + 2.0) / (1.0 - a * a);
    }
    ASSERT_TRUE(policy->last().log_probability);
    EXPECT_NEAR(*policy->last().log_probability, expected, 1e-5 + 1e-7 * sensitivity) << "sample " << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, SquashedGaussianTest, nn::AllIsas(), nn::IsaTestName);

TEST(SquashedGaussianLoadTest, RefusesAnotherLengthAndNamesATensorThatIsNotFinite) {
  const DrivingShape spec;
  const PolicyNetwork network(spec, {});
  const auto policy = MakeSquashedGaussianPolicy(spec, {}).value();
  EXPECT_EQ(policy->layout().size(), network.layout.size());
  EXPECT_EQ(policy->layout().hash(), network.layout.hash());
  std::vector<float> parameters = Parameters(network, 1);
  parameters.pop_back();
  EXPECT_EQ(policy->Load(parameters).error().code, ErrorCode::kInvalidArgument);
  parameters.push_back(0.0f);
  parameters[network.layout.Find("policy.hidden1.weight")->offset + 3] = std::nanf("");
  const Status status = policy->Load(parameters);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kCorrupt);
  EXPECT_NE(status.error().message.find("policy.hidden1.weight"), std::string::npos)
      << status.error().message;
}

TEST(SquashedGaussianLoadTest, FailedLoadKeepsThePolicyInUse) {
  const DrivingShape spec;
  const PolicyNetwork network(spec, {});
  const auto policy = MakeSquashedGaussianPolicy(spec, {}).value();
  std::vector<float> parameters = Parameters(network, 1);
  ASSERT_TRUE(policy->Load(parameters));
  const Observation observation = OneOf(GoldenObservations(0), spec, 1);
  const Action before = policy->Act(observation, nullptr);
  for (float& p : parameters) p *= 0.5f;
  parameters.front() = HUGE_VALF;
  ASSERT_FALSE(policy->Load(parameters));
  EXPECT_EQ(policy->Act(observation, nullptr), before);
}

TEST(SquashedGaussianLoadTest, LayoutsDifferBetweenModels) {
  ModelConfig blind;
  blind.context = false;
  EXPECT_NE(MakeSquashedGaussianPolicy(DrivingShape{}, {}).value()->layout().hash(),
            MakeSquashedGaussianPolicy(DrivingShape{}, blind).value()->layout().hash());
}

}  // namespace
}  // namespace dadrl
