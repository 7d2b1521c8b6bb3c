#include "replay/service/chores.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

constexpr Duration kInterval = std::chrono::milliseconds(20);

TEST(Chores, AreDoneAtTheirIntervalsFromTheirFirstTimeOn) {
  ManualClock clock;
  FaultBoard faults(clock);
  Chores chores(clock, faults);
  int often = 0;
  int seldom = 0;
  chores.Add(kInterval, clock.Now(), FaultKind::kState, [&] { return ++often, Status(); });
  chores.Add(5 * kInterval, clock.Now() + 5 * kInterval, FaultKind::kSync,
             [&] { return ++seldom, Status(); });
  for (int i = 0; i < 10; ++i, clock.Advance(kInterval)) {
    chores.DoDue();
    chores.DoDue();
  }
  EXPECT_EQ(often, 10);
  EXPECT_EQ(seldom, 1);
}

TEST(Chores, WhatFailedIsLeftAloneForAWhileAndThenGoesOn) {
  ManualClock clock;
  FaultBoard faults(clock);
  Chores chores(clock, faults);
  int attempts = 0;
  bool full = true;
  chores.Add(kInterval, clock.Now(), FaultKind::kState, [&]() -> Status {
    ++attempts;
    if (full) return Fail(ErrorCode::kExhausted, "the disk is full");
    return {};
  });
  const int in_a_minute = static_cast<int>(std::chrono::minutes(1) / kInterval);
  for (int i = 0; i < in_a_minute; ++i, clock.Advance(kInterval)) chores.DoDue();
  EXPECT_EQ(attempts, std::chrono::minutes(1) / Chores::kRetryInterval);
  EXPECT_TRUE(faults.Lasts(FaultKind::kState));
  full = false;
  attempts = 0;
  for (int i = 0; i < in_a_minute; ++i, clock.Advance(kInterval)) chores.DoDue();
  EXPECT_EQ(attempts, in_a_minute);
  EXPECT_FALSE(faults.Lasts(FaultKind::kState));
}

TEST(Chores, AFailureOfOneIsNoneOfTheOthers) {
  ManualClock clock;
  FaultBoard faults(clock);
  Chores chores(clock, faults);
  int done = 0;
  chores.Add(kInterval, clock.Now(), FaultKind::kSync,
             []() -> Status { return Fail(ErrorCode::kInternal, "not today"); });
  chores.Add(kInterval, clock.Now(), FaultKind::kState, [&] { return ++done, Status(); });
  for (int i = 0; i < 5; ++i, clock.Advance(kInterval)) chores.DoDue();
  EXPECT_EQ(done, 5);
  EXPECT_TRUE(faults.Lasts(FaultKind::kSync));
  EXPECT_FALSE(faults.Lasts(FaultKind::kState));
}

}  // namespace
}  // namespace dadrl
