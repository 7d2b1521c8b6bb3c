// Scalars that only an algorithm knows, on their way from its table to whoever trains with it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/dds/udp_socket.h"
#include "common/io/read_file.h"
#include "deploy/monitor/monitor_json.h"
#include "deploy/monitor/panel.h"
#include "learner/reporter.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/learner/test_learner.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;
using testing::Contains;
using testing::HasSubstr;

// Four updates of FakeAlgorithm, which reports "fit" always, "halting" in updates 2 and 4 (their numbers).
TEST(AlgorithmScalars, ReachTableTelemetryPanelAndJsonUnderTheirOwnNames) {
  ClusterConfig cluster;
  cluster.port = dds::FindFreePort().value();
  auto subscriber = TelemetrySubscriber::Create(TelemetryUrl(cluster));
  if (!subscriber) GTEST_SKIP() << "no multicast here: " << subscriber.error().message;
  const TemporaryFolder folder;
  TestLearner learner({}, folder.path() / "checkpoints", false);
  TelemetryPublisher telemetry(TelemetryUrl(cluster));
  const SystemClock clock;
  FaultBoard faults(clock);
  TrainingLog log(folder.path(), 0, learner.trainer->scalar_specs(), faults);
  {
    // Reports once, at its end.
    const Reporter reporter(
        {.enabled = true, .interval_s = 3600.0},
        {*learner.trainer, *learner.checkpoints, telemetry, log, [] { return FetchStats{}; }, clock}, 1);
    learner.Steps(4);
  }
  const std::string table = ReadTextFile(folder.path() / "logs" / "training.csv", 1 << 20).value();
  EXPECT_THAT(table, HasSubstr(",updates_per_s,fit,halting,weights_version,"));

  ClusterView view(10s, 10s);
  (*subscriber)
      ->Poll(
          0s, [&](const ProcessStatus& status) { view.Add(status, TimePoint{}); }, nullptr);
  const ClusterSummary summary = view.Summarize(TimePoint{});
  ASSERT_EQ(summary.scalars.size(), 2u);
  EXPECT_EQ(summary.scalars[0].name, "fit");
  EXPECT_EQ(summary.scalars[1], (NamedScalar{"halting", 3.0}));
  EXPECT_THAT(table, HasSubstr(fmt::format(",{:.9g},3,", summary.scalars[0].value)));

  const nlohmann::ordered_json json = MonitorJson(summary, "");
  EXPECT_EQ(json["losses"]["fit"], summary.scalars[0].value);
  EXPECT_EQ(json["losses"]["halting"], 3.0);
  EXPECT_EQ(json["processes"][0]["metrics"]["halting"], 3.0);
  Progress progress;
  progress.summary = summary;
  EXPECT_THAT(RenderPanel(progress, {}), Contains(HasSubstr(", halting 3")));
}

}  // namespace
}  // namespace dadrl
