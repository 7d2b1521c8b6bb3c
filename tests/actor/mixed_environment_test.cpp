#include "actor/mixed_environment.h"

#include <gmock/gmock.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "actor/sim/scenario.h"
#include "common/util/random.h"

namespace dadrl {
namespace {

Config ConfigFor(const std::string& scenario) {
  Config config;
  config.scenario = scenario;
  config.task.max_steps = 60;
  return config;
}

struct Record {
  std::vector<Observation> observations;
  EpisodeSummary summary;
  bool operator==(const Record&) const = default;
};

Record Drive(Environment& environment, uint64_t seed) {
  Random random(seed);
  Record record;
  EXPECT_TRUE(environment.Reset(seed));
  for (bool ended = false; !ended;) {
    record.observations.push_back(environment.observation());
    const auto step = environment.Step({static_cast<float>(random.Uniform(-1, 1)), 0.0f});
    EXPECT_TRUE(step);
    ended = !step || step->ended();
  }
  record.summary = environment.summary();
  return record;
}

TEST(MixedEnvironment, DrivesEveryScenarioTheSameAsAloneWhateverRanBefore) {
  std::map<std::string, Record> first_of;  // by scenario
  {
    const auto mixed = MakeDrivingEnvironment(ConfigFor("all"));
    ASSERT_TRUE(mixed) << mixed.error().message;
    for (uint64_t seed = 1; first_of.size() < ScenarioNames().size() && seed < 100; ++seed) {
      ASSERT_TRUE((*mixed)->Reset(seed));
      const Record record = Drive(**mixed, seed);
      first_of.emplace(record.summary.scenario, record);
    }
    for (const auto& [scenario, record] : first_of) {
      EXPECT_EQ(Drive(**mixed, record.summary.seed), record) << scenario << " after others";
    }
  }
  ASSERT_EQ(first_of.size(), ScenarioNames().size());
  for (const auto& [scenario, record] : first_of) {
    const auto alone = MakeDrivingEnvironment(ConfigFor(scenario));
    ASSERT_TRUE(alone);
    EXPECT_EQ(Drive(**alone, record.summary.seed), record) << scenario << " alone";
  }
}

// 2,000 draws from 5: each within 5 standard deviations (18) of 400. Only the draw is looked at: no traffic.
TEST(MixedEnvironment, DrawsAllScenariosAlike) {
  std::vector<int> counts(5);
  for (uint64_t seed = 0; seed < 2000; ++seed) ++counts[MixedEnvironment::ScenarioOf(seed, 5)];
  EXPECT_THAT(counts, testing::Each(testing::AllOf(testing::Gt(310), testing::Lt(490))));
}

}  // namespace
}  // namespace dadrl
