#include "deploy/local/resume_rules.h"

#include <gmock/gmock.h>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;

TEST(ResumeRules, AllowsWhatTheRunDoesNotDependOn) {
  for (const char* change :
       {"actor.count=7", "minutes=30", "cluster.port=12000", "replay.samples_per_insert=4",
        "algorithm.actor_learning_rate=0.0001", "evaluation.episodes=10", "learner.threads=2"}) {
    Config wanted;
    ASSERT_TRUE(ApplyOverride(change, wanted)) << change;
    EXPECT_TRUE(CheckResumable(Config{}, wanted)) << change;
  }
}

TEST(ResumeRules, RefusesWhatWeightsOrExperienceWereMadeWith) {
  for (const char* change : {"scenario=roundabout_a", "seed=2", "traffic.profile=plain",
                             "task.decision_interval=1", "task.reward.crash=-2", "observation.vehicles=8",
                             "model.hidden=128", "algorithm.gamma=0.9", "replay.shards=2"}) {
    Config wanted;
    ASSERT_TRUE(ApplyOverride(change, wanted)) << change;
    const Status status = CheckResumable(Config{}, wanted);
    ASSERT_FALSE(status) << change;
    EXPECT_EQ(ExitCode(status.error()), 2);
    const std::string text = change;
    EXPECT_THAT(status.error().message, HasSubstr(text.substr(0, text.find('='))));
  }
}

}  // namespace
}  // namespace dadrl
