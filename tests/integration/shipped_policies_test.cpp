// Every policy in deploy/policies, from its file to the road.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "common/model/policy_file.h"
#include "tests/deploy/cli/run_command.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

const fs::path kFolder = fs::path(DADRL_SOURCE_DIR) / "deploy/policies";
constexpr int kEpisodes = 30;
// Traffic that chose no policy and graded none.
constexpr const char* kFirstSeed = "3000000";

std::vector<std::string> PolicyNames() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(kFolder, error)) {
    if (entry.path().extension() == ".dadrl") names.push_back(entry.path().stem());
  }
  std::sort(names.begin(), names.end());
  return names;
}

// P(X <= hits) of a binomial X.
double BinomialTail(int hits, int trials, double rate) {
  double sum = 0.0;
  for (int k = 0; k <= hits; ++k) {
    const double log_choices = std::lgamma(trials + 1) - std::lgamma(k + 1) - std::lgamma(trials - k + 1);
    sum += std::exp(log_choices + k * std::log(rate) + (trials - k) * std::log1p(-rate));
  }
  return sum;
}

// Fewer successes than this come from a policy of this success rate once in ten thousand times.
int FewestSuccesses(int trials, double rate) {
  int fewest = 0;
  while (fewest < trials && BinomialTail(fewest, trials, rate) < 1e-4) ++fewest;
  return fewest;
}

// Without names, the tests of each policy would be none.
TEST(ShippedPolicies, AreThere) { EXPECT_GE(PolicyNames().size(), 6u) << kFolder; }

// At least 16 of 20 when the true rate is 98.5 %: 4 failures or fewer have P = 1 - 1.2e-5, 3 or fewer 1
// - 2.5e-4.
TEST(ShippedPolicies, TheBarIsWhereTheBinomialPutsIt) {
  EXPECT_EQ(FewestSuccesses(20, 0.985), 16);
  EXPECT_NEAR(BinomialTail(1, 3, 0.5), 0.5, 1e-12);
}

class ShippedPolicy : public testing::TestWithParam<std::string> {
 protected:
  json Record() const { return json::parse(FileText(kFolder / (GetParam() + ".json")), nullptr, false); }
};

TEST_P(ShippedPolicy, SaysWhereItComesFrom) {
  const json record = Record();
  ASSERT_TRUE(record.is_object()) << GetParam() << ".json is missing or damaged";
  const auto policy = LoadPolicy(kFolder / (GetParam() + ".dadrl"));
  ASSERT_TRUE(policy) << policy.error().message;
  EXPECT_EQ(record["scenario"], policy->config.scenario);
  const json& training = record["training"];
  EXPECT_EQ(training["updates"], policy->updates);
  EXPECT_EQ(training["seed"], policy->config.seed);
  EXPECT_FALSE(training["configuration"].empty());
  for (const char* key : {"commit", "machine", "env_steps", "training_s"})
    EXPECT_TRUE(training.contains(key)) << key;
  EXPECT_GE(record["evaluation"]["episodes"], 250);
}

// The bar is what the lower end of the recorded rate's interval still gives, so that only a policy gone bad
// (or an environment that changed under it) falls short, on any processor.
TEST_P(ShippedPolicy, StillDrives) {
  setenv("DADRL_POLICIES", kFolder.c_str(), 1);
  const json record = Record();
  const json& evaluation = record["evaluation"];
  const int scenarios =
      evaluation.contains("per_scenario") ? static_cast<int>(evaluation["per_scenario"].size()) : 1;
  const CommandOutput output =
      Dadrl({"evaluate", "--policy", "pretrained:" + GetParam(), "--episodes",
             std::to_string(kEpisodes / scenarios), "--seeds", "1", "--first-seed", kFirstSeed, "--json"},
            300);
  unsetenv("DADRL_POLICIES");
  ASSERT_EQ(output.exit_code, 0) << output.err;
  const json driven = json::parse(output.out);
  const int episodes = driven["episodes"];
  const auto successes = static_cast<int>(std::lround(driven["success"].get<double>() * episodes));
  const double worst_rate = evaluation["success_ci95"][0];
  EXPECT_GE(successes, FewestSuccesses(episodes, worst_rate))
      << "of " << episodes << " episodes, recorded success rate " << evaluation["success"];
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(ShippedPolicy);
INSTANTIATE_TEST_SUITE_P(All, ShippedPolicy, testing::ValuesIn(PolicyNames()),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace dadrl
