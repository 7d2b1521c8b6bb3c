#include "actor/collect/status_reporter.h"

#include <gtest/gtest.h>

#include <atomic>

#include "common/dds/node.h"
#include "tests/common/util/eventually.h"

namespace dadrl {
namespace {

TEST(StatusReporter, SaysWhatTheSourceKnowsAndWhomItWaitsFor) {
  ClusterConfig cluster;
  cluster.port = dds::FindFreePort().value();
  auto subscriber = TelemetrySubscriber::Create(TelemetryUrl(cluster));
  TelemetryPublisher publisher(TelemetryUrl(cluster));
  TelemetryConfig telemetry;
  telemetry.interval_s = 0.05;
  std::atomic<int> asked{0};
  const SystemClock clock;
  const TimeLedger ledger(clock);
  const StatusEnvelope envelope({dds::Role::kActor, 4, 99}, clock, ledger, clock.Now());
  const StatusReporter reporter(publisher, telemetry, envelope, clock,
                                {.fill = [](ProcessStatus& status) { status[Metric::kEnvSteps] = 17; },
                                 .waiting_for = [&] { return ++asked == 1 ? "the test" : ""; }});
  EXPECT_TRUE(Eventually([&] { return asked >= 2; }));
  if (!subscriber) GTEST_SKIP() << "a host without multicast has no telemetry";
  double steps = 0;
  EXPECT_TRUE(Eventually([&] {
    (*subscriber)
        ->Poll(std::chrono::milliseconds(10),
               [&](const ProcessStatus& status) {
                 EXPECT_EQ(status.index, 4);
                 EXPECT_EQ(status.incarnation, 99);
                 steps = status[Metric::kEnvSteps];
               },
               {});
    return steps == 17;
  }));
}

}  // namespace
}  // namespace dadrl
