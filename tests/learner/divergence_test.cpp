#include "learner/divergence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace dadrl {
namespace {

using testing::HasSubstr;

// As in the README's panel.
UpdateStats Usual() {
  return {.critic_loss = 0.616,
          .actor_loss = -2.6,
          .temperature = 0.0143,
          .entropy = -2.0,
          .mean_q = 2.6,
          .mean_target = 2.6};
}

TEST(DivergenceGuard, LetsATrainingLearn) {
  const DivergenceGuard guard{Config{}};
  EXPECT_TRUE(guard.Check(Usual(), 1));
  UpdateStats bad = Usual();  // as bad as the worst policy that goes on for ever
  bad.mean_q = bad.mean_target = -2700.0;
  bad.critic_loss = 2 * 2700.0 * 2700.0;
  EXPECT_TRUE(guard.Check(bad, 1));
}

TEST(DivergenceGuard, NamesWhatRunsAway) {
  const DivergenceGuard guard{Config{}};
  const struct {
    double UpdateStats::*field;
    double value;
    const char* name;
  } cases[] = {{&UpdateStats::critic_loss, 1e57, "the critic loss is 1e+57"},
               {&UpdateStats::mean_q, -1e30, "the mean Q value is 1e+30"},
               {&UpdateStats::mean_target, 5e4, "the mean target value is 5e+04"},
               {&UpdateStats::temperature, 1e5, "the temperature is 1e+05"}};
  for (const auto& c : cases) {
    for (const double value : {c.value, std::numeric_limits<double>::quiet_NaN()}) {
      UpdateStats stats = Usual();
      stats.*c.field = value;
      const Status checked = guard.Check(stats, 77);
      ASSERT_FALSE(checked) << c.name;
      if (value != value) continue;
      EXPECT_THAT(checked.error().message, HasSubstr(c.name));
      EXPECT_THAT(checked.error().message, HasSubstr("in update 77"));
      EXPECT_THAT(checked.error().message, HasSubstr("algorithm.critic_learning_rate"));
    }
  }
}

TEST(DivergenceGuard, LargerWeightsAndTemperaturesMayBringLargerValues) {
  Config config;
  config.task.reward.goal = 100.0;
  UpdateStats stats = Usual();
  stats.mean_q = 2e5;
  EXPECT_FALSE(DivergenceGuard(Config{}).Check(stats, 1));
  EXPECT_TRUE(DivergenceGuard(config).Check(stats, 1));
  stats.temperature = 1.0;
  EXPECT_TRUE(DivergenceGuard(Config{}).Check(stats, 1));
}

}  // namespace
}  // namespace dadrl
