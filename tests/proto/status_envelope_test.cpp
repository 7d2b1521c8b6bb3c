#include "proto/status_envelope.h"

#include <gtest/gtest.h>
#include <unistd.h>

namespace dadrl {
namespace {

TEST(StatusEnvelope, SaysWhoSinceWhenAndHowTheTimeGoes) {
  ManualClock clock;
  TimeLedger ledger(clock);
  clock.Advance(std::chrono::seconds(5));
  const StatusEnvelope envelope({dds::Role::kReplay, 3, 99}, clock, ledger, clock.Now());
  ledger.Enter(Activity::kWaitForInserts);
  clock.Advance(std::chrono::seconds(2));
  ProcessFaults().Report(FaultKind::kSync, Fail(ErrorCode::kExhausted, "no space left"));
  const ProcessStatus status = envelope.Begin();
  ProcessFaults().Report(FaultKind::kSync, {});
  EXPECT_EQ(status.role, dds::Role::kReplay);
  EXPECT_EQ(status.index, 3);
  EXPECT_EQ(status.pid, getpid());
  EXPECT_EQ(status.incarnation, 99u);
  EXPECT_EQ(status.sent_ns, clock.WallTimeNs());
  EXPECT_EQ(status.uptime_s, 2.0);
  EXPECT_EQ(status.activities[Activity::kWaitForInserts], (TimeSpent{1, 2.0}));
  ASSERT_EQ(status.faults.size(), 1u);
  EXPECT_EQ(status.faults[0].kind, FaultKind::kSync);
  EXPECT_TRUE(envelope.Begin().faults.empty());
}

}  // namespace
}  // namespace dadrl
