#include "learner/divergence.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace dadrl {
namespace {

using testing::HasSubstr;

enum Scalar { kLoss, kTemperature, kPolicyLoss, kQ, kTarget };

constexpr std::array kSpecs = {
    ScalarSpec{"value_loss", "loss/value", ScalarKind::kSquaredError},
    ScalarSpec{"heat", "policy/heat", ScalarKind::kTemperature},
    ScalarSpec{"policy_loss", "loss/policy"},
    ScalarSpec{"q", "value/q", ScalarKind::kValue},
    ScalarSpec{"target", "value/target", ScalarKind::kValue},
};

// As in the README's panel.
using Scalars = std::array<double, kSpecs.size()>;
constexpr Scalars kUsual = {0.616, 0.0143, -2.6, 2.6, 2.6};

DivergenceGuard Guard(const Config& config = {}) { return {config, kSpecs}; }

TEST(DivergenceGuard, LetsATrainingLearn) {
  EXPECT_TRUE(Guard().Check(kUsual, 1));
  Scalars bad = kUsual;  // as bad as the worst policy that goes on for ever
  bad[kQ] = bad[kTarget] = -2700.0;
  bad[kLoss] = 2 * 2700.0 * 2700.0;
  bad[kPolicyLoss] = 1e30;  // nothing bounds it
  EXPECT_TRUE(Guard().Check(bad, 1));
  bad[kPolicyLoss] = std::numeric_limits<double>::quiet_NaN();  // nor need there be one
  EXPECT_TRUE(Guard().Check(bad, 1));
}

TEST(DivergenceGuard, NamesWhatRunsAway) {
  const struct {
    Scalar scalar;
    double value;
    const char* name;
  } cases[] = {{kLoss, 1e57, "value_loss is 1e+57"},
               {kQ, -1e30, "q is 1e+30"},
               {kTarget, 5e4, "target is 5e+04"},
               {kTemperature, 1e5, "heat is 1e+05"}};
  for (const auto& c : cases) {
    for (const double value : {c.value, std::numeric_limits<double>::quiet_NaN()}) {
      Scalars scalars = kUsual;
      scalars[c.scalar] = value;
      const Status checked = Guard().Check(scalars, 77);
      ASSERT_FALSE(checked) << c.name;
      EXPECT_THAT(checked.error().message, HasSubstr(std::string(kSpecs[c.scalar].name) + " is"));
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
  Scalars scalars = kUsual;
  scalars[kQ] = 2e5;
  EXPECT_FALSE(Guard().Check(scalars, 1));
  EXPECT_TRUE(Guard(config).Check(scalars, 1));
  scalars[kTemperature] = 1.0;
  EXPECT_TRUE(Guard().Check(scalars, 1));
}

}  // namespace
}  // namespace dadrl
