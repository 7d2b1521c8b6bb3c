// What a user may set and what not: the one table of values that cannot work.
#include "common/config/validate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "common/config/config_schema.h"
#include "common/config/config_yaml.h"

namespace dadrl {
namespace {

// The refusal of these values together; empty when they are taken.
std::string Refusal(const std::vector<std::string>& sets) {
  Config config;
  Status status;
  for (const std::string& set : sets) {
    if (status) status = ApplyOverride(set, config);
  }
  if (status) status = Validate(config);
  if (status) return "";
  EXPECT_EQ(status.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(status.error().message.find('\n'), std::string::npos) << "one line";
  return status.error().message;
}

struct Case {
  std::vector<std::string> sets;
  std::string says;  // a part of the refusal: value, limit or remedy
};

TEST(Validate, RefusesWhatCannotWork) {
  const std::vector<Case> cases = {
      {{"algorithm.target_entropy=2"},
       "'2' is not a number between -100 and 1.33: two actions in [-1, 1] have at "
       "most 2 ln 2 = 1.386 nats"},
      {{"algorithm.adam_epsilon=0"}, "divided by zero"},
      {{"algorithm.tau=0"}, "with 0 the target would never move"},
      {{"algorithm.critic_learning_rate=0"}, "with 0 nothing is learnt"},
      {{"algorithm.actor_learning_rate=1"}, "between 1e-09 and 0.1"},
      {{"algorithm.batch_size=40"}, "40 is not a multiple of 16"},
      {{"algorithm.batch_size=32", "learner.threads=4"},
       "4 threads need algorithm.batch_size of at least 64"},
      {{"model.log_std_min=0", "model.log_std_max=0"}, "0 is not below model.log_std_max: 0"},
      {{"model.stae=false", "model.context=false"}, "keep one"},
      {{"model.scene=true", "observation.polylines=true"}, "set model.stae=false"},
      {{"model.scene=true", "model.stae=false"}, "observation.polylines is false; set it to true"},
      {{"algorithm.shift_pixels=17"}, "between 0 and 16"},
      {{"algorithm.shift_pixels=2", "model.context=false"},
       "algorithm.shift_pixels: 2 shifts bird's-eye planes, and model.context: false has none"},
      {{"algorithm.shift_pixels=2", "learner.threads=129", "algorithm.batch_size=4096"},
       "learner.threads: 129 is more than the 128"},
      {{"actor.policy=randon"},
       "'randon' is neither the path of a policy file nor one of: learned, random, rdm, slow, predictive; "
       "the nearest is 'random'"},
      {{"actor.policy=idm"}, "neither the path of a policy file"},
      {{"actor.keep=some"}, "not one of: all, successes"},
      {{"algorithm.gae_lambda=1.5"}, "between 0 and 1"},
      {{"algorithm.clip_ratio=0"}, "with 0 no update would change anything"},
      {{"learner.max_cpu_seconds=-1"}, "between 0 and 1e+09"},
      {{"task.reward.crash=0", "task.reward.off_road=0", "task.reward.goal=0", "task.reward.progress=0",
        "task.reward.speed=0", "task.reward.off_route=0", "task.reward.wrong_way=0", "task.reward.slow=0"},
       "nothing to learn"},
      {{"task.max_steps=20"}, "reach 20 steps back, and no episode is longer than task.max_steps: 20"},
      {{"replay.segment_bytes=1073741824", "replay.max_disk_bytes=1048576"}, "exceeds replay.max_disk_bytes"},
      {{"replay.min_size=1000000", "replay.max_disk_bytes=67108864"}, "nothing would ever be sampled"},
      {{"replay.min_size=1e15"}, "is not a whole number"},
      {{"replay.samples_per_insert=1e-12"}, "wait for 6.4e+13 frames; take at least 6.4e-05, or 0"},
      {{"replay.samples_per_insert=1", "replay.min_samples_per_insert=2"}, "both sides would wait"},
      {{"replay.max_items=10"}, "nothing would ever be sampled"},
      {{"replay.min_size=1", "replay.max_items=3", "replay.max_times_sampled=4"}, "never make a batch"},
      {{"replay.sampler=newest_first"}, "set it to at least 1"},
      {{"replay.sequence_period=5"}, "frames between would never be sampled"},
      {{"replay.snapshot_interval_s=1e-9"}, "below 1 s; take more, or 0 for none"},
      {{"evaluation.interval_s=0.5"}, "below 1 s"},
      {{"evaluation.episodes=1001"}, "a thousand traffic seeds"},
      {{"cluster.port=80"}, "one of the system's; take 1024 to 60000"},
      {{"cluster.port=60001"}, "between 0 and 60000"},
      {{"cluster.lease_s=0.5"}, "shorter than cluster.liveliness_s: 1"},
      {{"cluster.host="}, "not a text of 1 to 255 bytes"},
      {{"scenario=a\nb"}, "'a\\x0ab' is not a text"},
  };
  for (const Case& c : cases) {
    EXPECT_THAT(Refusal(c.sets), testing::HasSubstr(c.says)) << testing::PrintToString(c.sets);
  }
}

TEST(Validate, TakesTheEdgesThatWork) {
  const std::vector<std::vector<std::string>> cases = {
      {"algorithm.target_entropy=1.33"},
      {"algorithm.temperature_learning_rate=0"},
      {"algorithm.gamma=1"},
      {"replay.samples_per_insert=0"},
      {"replay.min_size=1", "replay.max_disk_bytes=1048576", "replay.segment_bytes=65536"},
      {"cluster.port=60000"},
      {"cluster.lease_s=1"},
      {"task.max_steps=21"},
      {"actor.count=0"},
      {"minutes=0.01"},
      {"algorithm.batch_size=4096"},
  };
  for (const auto& sets : cases) EXPECT_EQ(Refusal(sets), "") << testing::PrintToString(sets);
}

// Neither a NaN nor an infinity nor a value beyond either end passes, whatever the key.
TEST(Validate, EveryNumberHasARange) {
  Config config;
  for (const ConfigField& field : SchemaOf(config)) {
    const bool number = field.min < field.max;
    const bool text = std::holds_alternative<std::string*>(field.target);
    if (text) continue;
    for (const char* value : {"nan", "-nan", "inf", "-inf", "1e308", "-1e308", "99999999999999999999999", "",
                              " 1", "1 ", "0x10", "1,5", "one"}) {
      EXPECT_FALSE(AssignValue(field, value)) << field.key << " = '" << value << "'";
    }
    if (!number) continue;
    EXPECT_FALSE(AssignValue(field, fmt::format("{}", field.max * 2 + 1))) << field.key;
    EXPECT_FALSE(AssignValue(field, fmt::format("{}", field.min - 1))) << field.key;
  }
}

}  // namespace
}  // namespace dadrl
