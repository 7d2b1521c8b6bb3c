#include "replay/service/periodic_tasks.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

constexpr Duration kInterval = std::chrono::milliseconds(20);

TEST(PeriodicTasks, AreDoneAtTheirIntervalsFromTheirFirstTimeOn) {
  ManualClock clock;
  FaultBoard faults(clock);
  PeriodicTasks tasks(clock, faults);
  int often = 0;
  int seldom = 0;
  tasks.Add(kInterval, clock.Now(), FaultKind::kState, [&] { return ++often, Status(); });
  tasks.Add(5 * kInterval, clock.Now() + 5 * kInterval, FaultKind::kSync, [&] { return ++seldom, Status(); });
  for (int i = 0; i < 10; ++i, clock.Advance(kInterval)) {
    tasks.RunDue();
    tasks.RunDue();
  }
  EXPECT_EQ(often, 10);
  EXPECT_EQ(seldom, 1);
}

TEST(PeriodicTasks, WhatFailedIsLeftAloneForAWhileAndThenGoesOn) {
  ManualClock clock;
  FaultBoard faults(clock);
  PeriodicTasks tasks(clock, faults);
  int attempts = 0;
  bool full = true;
  tasks.Add(kInterval, clock.Now(), FaultKind::kState, [&]() -> Status {
    ++attempts;
    if (full) return Fail(ErrorCode::kExhausted, "the disk is full");
    return {};
  });
  const int in_a_minute = static_cast<int>(std::chrono::minutes(1) / kInterval);
  for (int i = 0; i < in_a_minute; ++i, clock.Advance(kInterval)) tasks.RunDue();
  EXPECT_EQ(attempts, std::chrono::minutes(1) / PeriodicTasks::kRetryInterval);
  EXPECT_TRUE(faults.Lasts(FaultKind::kState));
  full = false;
  attempts = 0;
  for (int i = 0; i < in_a_minute; ++i, clock.Advance(kInterval)) tasks.RunDue();
  EXPECT_EQ(attempts, in_a_minute);
  EXPECT_FALSE(faults.Lasts(FaultKind::kState));
}

TEST(PeriodicTasks, AFailureOfOneIsNoneOfTheOthers) {
  ManualClock clock;
  FaultBoard faults(clock);
  PeriodicTasks tasks(clock, faults);
  int done = 0;
  tasks.Add(kInterval, clock.Now(), FaultKind::kSync,
            []() -> Status { return Fail(ErrorCode::kInternal, "not today"); });
  tasks.Add(kInterval, clock.Now(), FaultKind::kState, [&] { return ++done, Status(); });
  for (int i = 0; i < 5; ++i, clock.Advance(kInterval)) tasks.RunDue();
  EXPECT_EQ(done, 5);
  EXPECT_TRUE(faults.Lasts(FaultKind::kSync));
  EXPECT_FALSE(faults.Lasts(FaultKind::kState));
}

}  // namespace
}  // namespace dadrl
