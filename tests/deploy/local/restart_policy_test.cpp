#include "deploy/local/restart_policy.h"

#include <gmock/gmock.h>

#include <csignal>

#include "common/util/exit_code.h"

namespace dadrl {
namespace {

using std::chrono::seconds;

Ended Crash(double uptime_s, bool ready = true) {
  return {
      .status = {.signaled = true, .value = SIGSEGV}, .uptime = FromSeconds(uptime_s), .was_ready = ready};
}
Ended Killed(double uptime_s, bool ready = true) {
  return {
      .status = {.signaled = true, .value = SIGKILL}, .uptime = FromSeconds(uptime_s), .was_ready = ready};
}
Ended Exit(int code, bool ready) {
  return {.status = {.signaled = false, .value = code}, .uptime = seconds(1), .was_ready = ready};
}

double DelayOf(const RestartDecision& decision) {
  const auto* restart = std::get_if<RestartAfter>(&decision);
  return restart != nullptr ? ToSeconds(restart->delay) : -1.0;
}

TEST(RestartPolicy, FirstRestartComesWithinTwoSeconds) {
  for (uint64_t seed = 0; seed < 100; ++seed) {
    RestartPolicy policy(RestartLimits{}, seed);
    const double delay = DelayOf(policy.OnEnd(TimePoint{}, Killed(300)));
    EXPECT_GE(delay, 0.5);
    EXPECT_LT(delay, 1.0);
  }
}

TEST(RestartPolicy, BacksOffExponentiallyUpToItsCap) {
  RestartPolicy policy(RestartLimits{}, 1);
  TimePoint now{};
  for (const double expected : {0.5, 1.0, 2.0, 4.0, 8.0, 16.0, 30.0, 30.0}) {
    const double delay = DelayOf(policy.OnEnd(now, Crash(5)));
    EXPECT_GE(delay, expected);
    EXPECT_LE(delay, 1.2 * expected);
    now += seconds(60);
  }
}

TEST(RestartPolicy, GivesUpAtOnceWhenAnotherHasItsPlace) {
  for (const bool ready : {false, true}) {
    RestartPolicy policy(RestartLimits{}, 1);
    const RestartDecision decision = policy.OnEnd(TimePoint{}, Exit(kExitTurnedAway, ready));
    ASSERT_TRUE(std::holds_alternative<GiveUp>(decision));
    EXPECT_THAT(std::get<GiveUp>(decision).reason, testing::HasSubstr("another process has its place"));
  }
}

TEST(RestartPolicy, StartsAnewAfterAStableMinute) {
  RestartPolicy policy(RestartLimits{}, 1);
  for (int i = 0; i < 5; ++i) policy.OnEnd(TimePoint{} + seconds(i), Crash(5));
  EXPECT_LT(DelayOf(policy.OnEnd(TimePoint{} + seconds(100), Crash(61))), 1.0);
}

TEST(RestartPolicy, WhatHangsBeforeItIsReadyIsGivenUpAlthoughItWasKilled) {
  Ended hung = Killed(60, false);
  hung.hung = true;
  RestartPolicy policy(RestartLimits{}, 1);
  for (int i = 1; i <= 3; ++i) EXPECT_GT(DelayOf(policy.OnEnd(TimePoint{} + i * seconds(60), hung)), 0.0);
  EXPECT_TRUE(std::holds_alternative<GiveUp>(policy.OnEnd(TimePoint{} + seconds(240), hung)));
}

TEST(RestartPolicy, GivesUpAfterManyFailuresInAWindowButNotOverDays) {
  RestartPolicy tight(RestartLimits{}, 1);
  int starts = 0;
  while (std::holds_alternative<RestartAfter>(tight.OnEnd(TimePoint{} + seconds(starts), Crash(30))))
    ++starts;
  EXPECT_EQ(starts, 19);
  RestartPolicy sparse(RestartLimits{}, 1);
  for (int i = 0; i < 1000; ++i) {
    ASSERT_GE(DelayOf(sparse.OnEnd(TimePoint{} + std::chrono::hours(i), Crash(3600))), 0.0);
  }
}

TEST(RestartPolicy, GivesUpSoonOnWhatNeverComesUp) {
  RestartPolicy policy(RestartLimits{}, 1);
  for (int i = 0; i < 3; ++i) ASSERT_GE(DelayOf(policy.OnEnd(TimePoint{}, Exit(1, false))), 0.0);
  const RestartDecision decision = policy.OnEnd(TimePoint{}, Exit(1, false));
  ASSERT_TRUE(std::holds_alternative<GiveUp>(decision));
  EXPECT_EQ(std::get<GiveUp>(decision).reason, "it failed 4 times before it was ready");
}

TEST(RestartPolicy, GivesUpAtOnceOnWrongUsageAtStartOnly) {
  RestartPolicy at_start(RestartLimits{}, 1);
  EXPECT_TRUE(std::holds_alternative<GiveUp>(at_start.OnEnd(TimePoint{}, Exit(2, false))));
  RestartPolicy later(RestartLimits{}, 1);
  EXPECT_GE(DelayOf(later.OnEnd(TimePoint{}, Exit(2, true))), 0.0);
}

TEST(RestartPolicy, KillsFromOutsideAreNotStartUpFailures) {
  RestartPolicy policy(RestartLimits{}, 1);
  for (int i = 0; i < 10; ++i) {
    EXPECT_GE(DelayOf(policy.OnEnd(TimePoint{} + std::chrono::minutes(i), Killed(1, false))), 0.0);
  }
}

}  // namespace
}  // namespace dadrl
