#include <gmock/gmock.h>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "deploy/local/executables.h"
#include "tests/deploy/cli/run_command.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::MatchesRegex;

constexpr const char* kConfigFolder = DADRL_SOURCE_DIR "/deploy/config/";

TEST(ConfigCommand, DefaultYamlIsUpToDate) {
  const CommandOutput output = Dadrl({"config", "--explain"});
  EXPECT_EQ(output.exit_code, 0);
  EXPECT_EQ(output.out, FileText(std::string(kConfigFolder) + "default.yaml"))
      << "renew it: build/release/bin/dadrl config --explain > deploy/config/default.yaml";
}

TEST(ConfigCommand, PrintsWhatItWasGiven) {
  const CommandOutput output = Dadrl({"config", "--set", "algorithm.gamma=0.9", "--set", "seed=7"});
  EXPECT_EQ(output.exit_code, 0);
  Config config;
  ASSERT_TRUE(ParseYaml(output.out, "output", config));
  EXPECT_EQ(config.algorithm.gamma, 0.9);
  EXPECT_EQ(config.seed, 7u);
}

TEST(ConfigCommand, PaperYamlIsValidAndThePapers) {
  Config config;
  const Status loaded = LoadYaml(std::string(kConfigFolder) + "paper.yaml", config);
  ASSERT_TRUE(loaded) << loaded.error().message;
  EXPECT_TRUE(Validate(config));
  EXPECT_EQ(config.task.decision_interval, 1);
  EXPECT_EQ(config.algorithm.gamma, 0.99);
  EXPECT_EQ(config.algorithm.n_step, 1);
  EXPECT_EQ(config.algorithm.batch_size, 64);
  EXPECT_EQ(config.algorithm.critic_learning_rate, 3e-4);
  EXPECT_EQ(config.algorithm.initial_temperature, 1.0);
  EXPECT_FALSE(config.model.critic_layer_norm);
  EXPECT_EQ(config.learner.publish, PublishedPolicy::kCurrent);
}

// One for each scenario and one for all of them: what deploy/reproduce.sh trains with.
TEST(ConfigCommand, EveryScenarioHasARecipeThatNamesIt) {
  std::vector<std::string> names = ScenarioNames();
  ASSERT_EQ(names.size(), 5u);
  names.emplace_back(kAllScenarios);
  for (const std::string& name : names) {
    Config config;
    const Status loaded = LoadYaml(std::string(kConfigFolder) + "scenarios/" + name + ".yaml", config);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_TRUE(Validate(config));
    EXPECT_EQ(config.scenario, name);
    EXPECT_GT(config.learner.max_updates, 0) << name << " has no end";
  }
}

TEST(Help, NamesEveryCommandAndTheVersion) {
  const CommandOutput help = Dadrl({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command :
       {"train", "evaluate", "monitor", "actor", "doctor", "config", "export", "act", "policies"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
  }
  const CommandOutput version = Dadrl({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, MatchesRegex("dadrl [0-9.]+ \\([0-9a-z-]+\\)\n"));
}

}  // namespace
}  // namespace dadrl
