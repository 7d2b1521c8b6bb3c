#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"
#include "common/config/validate.h"
#include "deploy/local/executables.h"
#include "learner/algorithms/registry.h"
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

TEST(ConfigCommand, PolicyThatThereIsNotIsRefusedWithTheNearestByEveryCommand) {
  const std::vector<std::string> set = {"--set", "model.policy=squashed_gausian"};
  const std::vector<std::vector<std::string>> commands = {
      {"config"}, {"train", "left_turn"}, {"evaluate", "--policy", "rdm", "--scenario", "left_turn"}};
  for (std::vector<std::string> command : commands) {
    SCOPED_TRACE(command.front());
    command.insert(command.end(), set.begin(), set.end());
    const CommandOutput output = Dadrl(command);
    EXPECT_EQ(output.exit_code, 2);
    EXPECT_THAT(output.err, HasSubstr("did you mean squashed_gaussian?"));
    EXPECT_EQ(std::count(output.err.begin(), output.err.end(), '\n'), 1) << output.err;
  }
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

TEST(Presets, ThereIsOneForEachAlgorithmAndItSetsOnlyWhatExists) {
  std::vector<std::string> presets, algorithms;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(kConfigFolder) + "algorithms")) {
    const std::string name = presets.emplace_back(entry.path().stem());
    Config config;
    config.algorithm.name = name;
    const Status loaded = LoadYaml(entry.path(), config);
    ASSERT_TRUE(loaded) << loaded.error().message;
    EXPECT_EQ(config.algorithm.name, name) << "a preset does not choose the algorithm";
    const Status valid = Validate(config);
    EXPECT_TRUE(valid) << valid.error().message;
    const auto algorithm = FindAlgorithm(name);
    ASSERT_TRUE(algorithm) << algorithm.error().message;
    const Status checked = CheckNeeds(config, (*algorithm)->spec(config));
    EXPECT_TRUE(checked) << checked.error().message;
  }
  for (const AlgorithmEntry& entry : Algorithms()) algorithms.emplace_back(entry.name);
  EXPECT_THAT(presets, testing::UnorderedElementsAreArray(algorithms));
}

Config Effective(const std::vector<std::string>& options) {
  std::vector<std::string> arguments = {"config"};
  arguments.insert(arguments.end(), options.begin(), options.end());
  const CommandOutput output = Dadrl(arguments);
  EXPECT_EQ(output.exit_code, 0) << output.err;
  Config config;
  EXPECT_TRUE(ParseYaml(output.out, "output", config));
  return config;
}

TEST(Presets, StandBetweenTheDefaultsAndWhatTheUserGives) {
  const TemporaryFolder folder;
  const std::string named = folder.path() / "named.yaml";
  std::ofstream(named) << "algorithm:\n  name: sac\n";
  const std::string whole = folder.path() / "whole.yaml";
  std::ofstream(whole) << "algorithm:\n  name: sac\nmodel:\n  stae: true\n";
  EXPECT_TRUE(Effective({}).model.stae);
  EXPECT_FALSE(Effective({"--set", "algorithm.name=sac"}).model.stae);
  EXPECT_FALSE(Effective({"--config", named}).model.stae);
  EXPECT_TRUE(Effective({"--config", whole}).model.stae) << "as configurations written before presets";
  EXPECT_TRUE(Effective({"--config", named, "--set", "model.stae=true"}).model.stae);
  EXPECT_TRUE(Effective({"--config", named, "--set", "algorithm.name=dadrl"}).model.stae);
  EXPECT_EQ(Effective({"--config", named}).algorithm.name, "sac");
}

TEST(Presets, AreNotForARunThatIsResumed) {
  const TemporaryFolder folder;
  Config config;
  config.algorithm.name = "sac";  // with attention: as runs did before there were presets
  std::ofstream(folder.path() / "config.yaml") << ToYaml(config, false);
  const std::vector<std::string> resume = {"train", "--resume", "--run-dir", folder.path(), "--set"};
  const auto refusal = [&](const std::string& set) {
    std::vector<std::string> arguments = resume;
    arguments.push_back(set);
    return Dadrl(arguments).err;
  };
  // Not model.stae, which comes before it.
  EXPECT_THAT(refusal("algorithm.gamma=0.5"), HasSubstr("cannot change algorithm.gamma from 0.998 to 0.5"));
  EXPECT_THAT(refusal("algorithm.name=dadrl"), HasSubstr("cannot change algorithm.name from sac to dadrl"));
}

TEST(AlgorithmsCommand, ListsEachWithASentenceAndWhatItReports) {
  const CommandOutput text = Dadrl({"algorithms"});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  const CommandOutput output = Dadrl({"algorithms", "--json"});
  EXPECT_EQ(output.exit_code, 0);
  const auto rows = nlohmann::json::parse(output.out)["algorithms"];
  ASSERT_EQ(rows.size(), Algorithms().size());
  for (size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(rows[i]["name"], Algorithms()[i].name);
    EXPECT_THAT(text.out, HasSubstr(Algorithms()[i].description));
    const AlgorithmSpec spec = Algorithms()[i].spec(Config{});
    ASSERT_EQ(rows[i]["scalars"].size(), spec.scalars.size());
    EXPECT_EQ(rows[i]["scalars"][0], spec.scalars[0].name);
    EXPECT_EQ(rows[i]["gives_priorities"], spec.gives_priorities);
  }
}

TEST(AlgorithmsCommand, AnUnknownNameIsRefusedByWhateverTakesAConfiguration) {
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"config"},
        {"train", "left_turn"},
        {"evaluate", "--policy", "random", "--scenario", "left_turn"}}) {
    std::vector<std::string> arguments = command;
    arguments.insert(arguments.end(), {"--set", "algorithm.name=dadlr"});
    const CommandOutput output = Dadrl(arguments);
    EXPECT_EQ(output.exit_code, 2);
    EXPECT_THAT(output.err, HasSubstr("'dadlr' is unknown; the nearest is 'dadrl' (there are: "));
  }
}

TEST(Help, NamesEveryCommandAndTheVersion) {
  const CommandOutput help = Dadrl({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  for (const char* command : {"train", "evaluate", "monitor", "actor", "doctor", "config", "export", "act",
                              "policies", "algorithms"}) {
    EXPECT_THAT(help.out, HasSubstr(command));
  }
  const CommandOutput version = Dadrl({"--version"});
  EXPECT_EQ(version.exit_code, 0);
  EXPECT_THAT(version.out, MatchesRegex("dadrl [0-9.]+ \\([0-9a-z-]+\\)\n"));
}

}  // namespace
}  // namespace dadrl
