#include "learner/algorithms/registry.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"
#include "proto/named_scalar.h"
#include "tests/learner/fake_algorithm.h"
#include "tests/paths.h"

namespace dadrl {
namespace {

using testing::AllOf;
using testing::HasSubstr;

// Its preset, made small.
Config Small(std::string_view name) {
  Config config;
  config.algorithm.name = name;
  const auto preset =
      std::filesystem::path(DADRL_SOURCE_DIR) / "deploy/config/algorithms" / (std::string(name) + ".yaml");
  if (std::filesystem::exists(preset)) {
    EXPECT_TRUE(LoadYaml(preset, config)) << name;
  }
  config.algorithm.batch_size = 16;
  config.model.hidden = 16;
  return config;
}

TEST(Registry, EachAlgorithmIsMadeAndDeclaresWhatItsEntrySays) {
  for (const AlgorithmEntry& entry : Algorithms()) {
    Config config = Small(entry.name);
    const std::filesystem::path presets = std::string(DADRL_SOURCE_DIR) + "/deploy/config/algorithms";
    ASSERT_TRUE(LoadYaml(presets / (std::string(entry.name) + ".yaml"), config)) << entry.name;
    const auto algorithm = MakeAlgorithm(config);
    ASSERT_TRUE(algorithm) << algorithm.error().message;
    const AlgorithmSpec said = entry.spec(config);
    const AlgorithmSpec& declared = (*algorithm)->spec();
    EXPECT_EQ(declared.scalars.data(), said.scalars.data()) << entry.name;
    EXPECT_EQ(declared.gives_priorities, said.gives_priorities) << entry.name;
    EXPECT_EQ(declared.acts_from_start, said.acts_from_start) << entry.name;
    EXPECT_EQ(declared.on_policy, said.on_policy) << entry.name;
    EXPECT_EQ((*algorithm)->scalars().size(), said.scalars.size()) << entry.name;
    EXPECT_FALSE(entry.description.empty());
  }
}

TEST(Registry, EveryScalarHasANameThatTelemetryCarries) {
  for (const AlgorithmEntry& entry : Algorithms()) {
    std::set<std::string_view> names, tags;
    const AlgorithmSpec spec = entry.spec(Small(entry.name));
    EXPECT_LE(std::ssize(spec.scalars), kMaxScalars) << entry.name;
    for (const ScalarSpec& scalar : spec.scalars) {
      EXPECT_TRUE(IsScalarName(scalar.name)) << scalar.name;
      EXPECT_TRUE(names.insert(scalar.name).second) << scalar.name;
      EXPECT_TRUE(tags.insert(scalar.tag).second) << scalar.tag;
    }
  }
}

TEST(Registry, AnUnknownNameIsRefusedWithTheNearest) {
  const auto unknown = MakeAlgorithm(Small("sad"));
  ASSERT_FALSE(unknown);
  EXPECT_EQ(unknown.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(unknown.error().message,
              AllOf(HasSubstr("'sad'"), HasSubstr("the nearest is 'sac'"), HasSubstr("there are: ")));
  EXPECT_THAT(FindAlgorithm("\x1b[2J").error().message, HasSubstr("\\x1b"));
}

TEST(Registry, AReplayThatGoesByPrioritiesNeedsAnAlgorithmThatGivesThem) {
  Config config;
  EXPECT_TRUE(CheckNeeds(config, {}));
  config.replay.max_items = 5000;
  config.replay.remover = SamplerKind::kLowestPriority;
  EXPECT_TRUE(CheckNeeds(config, {.scalars = {}, .gives_priorities = true, .acts_from_start = false}));
  EXPECT_THAT(
      CheckNeeds(config, {}).error().message,
      HasSubstr("replay.remover goes by priorities, and algorithm.name: dadrl gives none; set it to"));
  config.replay.sampler = SamplerKind::kPrioritized;
  EXPECT_THAT(CheckNeeds(config, {}).error().message, testing::StartsWith("replay.sampler goes by"));
}

TEST(Registry, ActorsWaitForAPolicyExactlyWhereItComesBeforeExperience) {
  const AlgorithmSpec on_policy{.batch = {}, .scalars = {}, .acts_from_start = true};
  Config config;
  config.algorithm.name = "ppo";
  EXPECT_THAT(CheckNeeds(config, on_policy).error().message,
              HasSubstr("actor.wait_for_policy: false does not suit algorithm.name: ppo, whose first policy "
                        "comes before any experience; set it to true"));
  config.actor.wait_for_policy = true;
  EXPECT_TRUE(CheckNeeds(config, on_policy));
  EXPECT_THAT(CheckNeeds(config, {}).error().message,
              AllOf(HasSubstr("actor.wait_for_policy: true"), HasSubstr("set it to false")));
  config.actor.policy = "predictive";
  EXPECT_THAT(CheckNeeds(config, on_policy).error().message,
              AllOf(HasSubstr("actor.policy"), HasSubstr("set it to learned")));
}

TEST(Registry, ABatchIsAsLongAsTheAlgorithmAsksForIt) {
  Config config = Small("dadrl");
  config.algorithm.batch_size = 4096;
  EXPECT_TRUE(CheckNeeds(config, Algorithms().front().spec(config)));
  const AlgorithmSpec sequences{.batch = {.count = 512, .steps = 64, .all_observations = true},
                                .scalars = {}};
  EXPECT_THAT(CheckNeeds(config, sequences).error().message,
              AllOf(HasSubstr("algorithm.batch_size: 33280 observations of a batch of algorithm.name: dadrl"),
                    HasSubstr("at most 67108864 are sent at once; lower it")));
  config.observation.vehicles = 64;
  config.observation.history = 50;
  EXPECT_THAT(CheckNeeds(config, Algorithms().front().spec(config)).error().message,
              HasSubstr("algorithm.batch_size: 8192 observations"));
}

TEST(Registry, AnAlgorithmTrainsTheNetworkThatActs) {
  const Config config = Small("sac");
  const Status refused = CheckTrainsPolicy(config, FakeAlgorithm().published_policy());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(refused.error().message,
              AllOf(HasSubstr("algorithm.name: sac trains a network of 200 parameters (layout 0xfa4e)"),
                    HasSubstr("model.policy: squashed_gaussian acts with one of ")));
}

TEST(Registry, OnPolicyEveryKeyThatWouldLetItTrainOnAnythingElseIsRefused) {
  struct Case {
    std::string set, says;
  };
  const std::vector<Case> cases = {
      {"model.log_probability=false", "reads the decision column log_probability"},
      {"actor.policy=rdm", "set it to learned"},
      {"actor.wait_for_policy=false", "set it to true"},
      {"replay.max_times_sampled=2", "replay.max_times_sampled: 2 is not for that; set it to 1"},
      {"replay.max_staleness=0", "replay.max_staleness: 0"},
      {"replay.min_samples_per_insert=0", "actors wait rather than go stale"},
      {"replay.sequence_length=0", "replay.sequence_length: 0"},
      {"replay.sequence_period=1", "no step is drawn twice"},
      {"algorithm.rollout=16", "at least replay.sequence_length"}};
  for (const Case& c : cases) {
    Config config = Small("ppo");
    ASSERT_TRUE(MakeAlgorithm(config));
    ASSERT_TRUE(ApplyOverride(c.set, config));
    const auto made = MakeAlgorithm(config);
    ASSERT_FALSE(made) << c.set;
    EXPECT_EQ(made.error().code, ErrorCode::kInvalidArgument);
    EXPECT_THAT(made.error().message, HasSubstr(c.says));
  }
}

}  // namespace
}  // namespace dadrl
