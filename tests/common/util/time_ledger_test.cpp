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
  const TimeLedger::Totals totals = ledger.Read();
  EXPECT_DOUBLE_EQ(totals[static_cast<size_t>(Activity::kWork)], 6.0);
  EXPECT_DOUBLE_EQ(totals[static_cast<size_t>(Activity::kWaitForBatch)], 3.0);
  EXPECT_DOUBLE_EQ(totals[static_cast<size_t>(Activity::kWaitForDisk)], 0.0);
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
