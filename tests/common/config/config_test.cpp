#include <gtest/gtest.h>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"
#include "common/config/validate.h"

namespace dadrl {
namespace {

TEST(Config, RoundTripsThroughYaml) {
  Config config;
  config.algorithm.gamma = 0.987654321;
  config.model.encoders = EncoderSharing::kShared;
  config.task.reward.crash = -2.5;
  config.replay.max_memory_bytes = 123456789012;
  for (const bool explain : {false, true}) {
    const std::string yaml = ToYaml(config, explain);
    Config loaded;
    const Status status = ParseYaml(yaml, "test", loaded);
    ASSERT_TRUE(status) << status.error().message << "\n" << yaml;
    EXPECT_EQ(ToYaml(loaded, explain), yaml);
    EXPECT_EQ(loaded.algorithm.gamma, 0.987654321);
    EXPECT_EQ(loaded.task.reward.crash, -2.5);
  }
}

TEST(Config, DefaultsAreInsideTheirOwnRanges) {
  Config config;
  ASSERT_TRUE(Validate(config));
  for (const ConfigField& field : SchemaOf(config)) {
    const Status status = AssignValue(field, FormatValue(field));
    EXPECT_TRUE(status) << (status ? "" : status.error().message);
    EXPECT_FALSE(field.help.empty()) << field.key;
  }
}

TEST(Config, RefusesUnknownKeyWithNearestNameAndLine) {
  Config config;
  const Status status = ParseYaml("seed: 3\nalgorithm:\n  gama: 0.9\n", "run.yaml", config);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(status.error().message,
            "run.yaml:3: unknown key 'algorithm.gama'; the nearest is 'algorithm.gamma'");
}

TEST(Config, RefusesValueOutOfRange) {
  Config config;
  const Status status = ApplyOverride("algorithm.gamma=1.5", config);
  ASSERT_FALSE(status);
  EXPECT_EQ(status.error().message, "--set: algorithm.gamma: '1.5' is not a number between 0 and 1");
  EXPECT_EQ(config.algorithm.gamma, Config{}.algorithm.gamma);
}

TEST(Config, RefusesWrongChoiceAndBrokenYaml) {
  Config config;
  EXPECT_EQ(ApplyOverride("model.encoders=both", config).error().message,
            "--set: model.encoders: 'both' is not one of: separate, shared");
  EXPECT_FALSE(ParseYaml("a: [1", "x", config));
  EXPECT_FALSE(ParseYaml("- 1\n- 2\n", "x", config));
  EXPECT_FALSE(ParseYaml("seed: [1, 2]\n", "x", config));
  EXPECT_FALSE(ApplyOverride("seed", config));
  EXPECT_TRUE(ParseYaml("", "empty", config));
}

TEST(Config, RefusesUnknownAndMisplacedSections) {
  Config config;
  EXPECT_EQ(ParseYaml("task: {nonsense: {}}\n", "x", config).error().message,
            "x:1: unknown section 'task.nonsense'; the nearest is 'task.reward'");
  EXPECT_EQ(ParseYaml("tasks:\n", "x", config).error().message,
            "x:1: unknown section 'tasks'; the nearest is 'task'");
  EXPECT_EQ(ParseYaml("seed: {}\n", "x", config).error().message, "x:1: 'seed' needs one value");
  EXPECT_EQ(ParseYaml("task: 3\n", "x", config).error().message,
            "x:1: 'task' needs 'key: value' lines below it");
  EXPECT_EQ(ParseYaml("seed: 1\ntask:\n", "x", config).error().message,
            "x:2: 'task' needs 'key: value' lines below it");
}

TEST(Config, SectionsThatNobodyAskedForMayBeAnything) {
  Config config;
  constexpr std::string_view kWanted[] = {"seed"};
  ASSERT_TRUE(ParseYamlSections("seed: 7\nlater: {of: [another, version]}\n", "x", kWanted, config));
  EXPECT_EQ(config.seed, 7u);
  EXPECT_FALSE(ParseYamlSections("seed: 7\nlater: &a [*a]\n", "x", kWanted, config));
}

TEST(Config, NamesThatYamlWouldReadOtherwiseAreQuoted) {
  for (const char* name : {"on ramp", "null", "a: b", "it's", "-", "#1", "~", "[x]", "\xc3\xa4"}) {
    Config config;
    config.scenario = name;
    Config loaded;
    const Status status = ParseYaml(ToYaml(config, false), "x", loaded);
    ASSERT_TRUE(status) << status.error().message;
    EXPECT_EQ(loaded.scenario, name);
  }
}

TEST(Config, RefusesContradictions) {
  Config config;
  config.algorithm.batch_size = 40;
  EXPECT_EQ(Validate(config).error().message, "algorithm.batch_size: 40 is not a multiple of 16");
  config = {};
  config.learner.threads = 8;
  EXPECT_FALSE(Validate(config));
  config = {};
  config.model.stae = config.model.context = false;
  EXPECT_FALSE(Validate(config));
  config = {};
  config.replay.shards = 2;
  config.replay.max_items = 999;
  EXPECT_EQ(
      Validate(config).error().message,
      "replay.max_items: 999 is less than a shard's part of replay.min_size, 1000; nothing would ever be "
      "sampled");
  config.replay.max_items = 1000;
  EXPECT_TRUE(Validate(config));
  config.replay.min_size = 1;
  config.replay.max_items = 31;
  EXPECT_TRUE(Validate(config)) << "each serves as often as it is sampled";
  config.replay.max_times_sampled = 2;
  EXPECT_EQ(Validate(config).error().message,
            "replay.max_items: 31 items of replay.max_times_sampled: 2 never make a batch of "
            "algorithm.batch_size: 64; nothing would ever be sampled");
  config.replay.max_items = 32;
  EXPECT_TRUE(Validate(config));
}

}  // namespace
}  // namespace dadrl
