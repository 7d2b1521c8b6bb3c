#include "common/util/time_ledger.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace dadrl {
namespace {

using std::chrono::seconds;

TEST(TimeLedger, CountsEachActivityAndTheRunningOne) {
  ManualClock clock;
  TimeLedger ledger(clock);
  clock.Advance(seconds(5));  // before the first Enter: nobody's
  ledger.Enter(Activity::kWork);
  clock.Advance(seconds(2));
  {
    ScopedActivity wait(ledger, Activity::kWaitForBatch);
    clock.Advance(seconds(3));
  }
  clock.Advance(seconds(4));
  const ActivityTotals totals = ledger.Read();
  EXPECT_EQ(totals[Activity::kWork], (TimeSpent{2, 6.0}));
  EXPECT_EQ(totals[Activity::kWaitForBatch], (TimeSpent{1, 3.0}));
  EXPECT_EQ(totals[Activity::kWaitForDisk], (TimeSpent{0, 0.0}));
  EXPECT_DOUBLE_EQ(totals.AllSeconds(), 9.0);
}

TEST(TimeLedger, GoingOnWithAWaitIsNoNewOne) {
  ManualClock clock;
  TimeLedger ledger(clock);
  for (int poll = 0; poll < 5; ++poll) {
    ledger.Enter(Activity::kWaitForInserts);
    clock.Advance(seconds(1));
  }
  ledger.Enter(Activity::kWaitForBatch);
  ledger.Enter(Activity::kWaitForInserts);
  EXPECT_EQ(ledger.Read()[Activity::kWaitForInserts], (TimeSpent{2, 5.0}));
}

TEST(TimeLedger, NamesEveryActivityOnce) {
  std::set<std::string> names;
  for (int i = 0; i < static_cast<int>(Activity::kCount); ++i) {
    names.emplace(ActivityName(static_cast<Activity>(i)));
  }
  EXPECT_EQ(names.size(), static_cast<size_t>(Activity::kCount));
  EXPECT_FALSE(names.contains("unknown"));
}

}  // namespace
}  // namespace dadrl
