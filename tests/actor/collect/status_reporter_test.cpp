#include "actor/collect/status_reporter.h"

#include <gtest/gtest.h>

#include <atomic>

#include "tests/actor/experience/replay_peer.h"

namespace dadrl {
namespace {

TEST(StatusReporter, BeatsAndSaysWhatTheSourceKnows) {
  ClusterConfig cluster;
  cluster.port = dds::FindFreePort().value();
  const auto replay = dds::Node::Create(cluster, 1, dds::Role::kReplay, 0).value();
  const auto beats = dds::Reader<dadrl_idl_Heartbeat>::Create(*replay, kHeartbeatTopic).value();
  const auto actor = dds::Node::Create(cluster, 1, dds::Role::kActor, 4).value();
  auto subscriber = TelemetrySubscriber::Create(TelemetryUrl(cluster));
  TelemetryPublisher publisher(TelemetryUrl(cluster));
  TelemetryConfig telemetry;
  telemetry.interval_s = 0.05;
  std::atomic<int> asked{0};
  auto reporter =
      StatusReporter::Start(*actor, publisher, telemetry, 4, 99,
                            {.fill = [](ProcessStatus& status) { status[Metric::kEnvSteps] = 17; },
                             .ticks = [] { return uint64_t{1}; },
                             .waiting_for = [&] { return ++asked == 1 ? "the test" : ""; }})
          .value();
  dadrl_idl_Heartbeat last{};
  EXPECT_TRUE(Eventually([&] {
    beats->Take(100, [&](const dadrl_idl_Heartbeat& beat) { last = beat; });
    return last.beat >= 3;
  }));
  EXPECT_EQ(last.role, static_cast<uint32_t>(dds::Role::kActor));
  EXPECT_EQ(last.index, 4);
  EXPECT_EQ(last.incarnation, 99);
  EXPECT_EQ(beats->alive(), 1);
  EXPECT_GE(asked, 1);
  if (subscriber) {  // a host without multicast has no telemetry
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
  reporter = nullptr;
  EXPECT_TRUE(Eventually([&] { return beats->alive() == 0; }));
}

}  // namespace
}  // namespace dadrl
