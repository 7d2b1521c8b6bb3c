// `dadrl replay limit | snapshot` on a replay at work, and what it says of the snapshots it finds.
#include <gmock/gmock.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "proto/telemetry.h"
#include "tests/paths.h"
#include "tests/replay/run_tool.h"
#include "tests/replay/service/service_fixture.h"

namespace dadrl {
namespace {

using LiveTools = ReplayServiceTest;

TEST_F(LiveTools, ASnapshotIsTakenWhileExperienceComesIn) {
  Launch();
  AddChunks(3000);
  ASSERT_TRUE(actor_->PumpUntilStored(50)) << replay_->Log();
  const std::string run = (folder_.path() / "run").string();
  std::FILE* asking = popen(
      (std::string(DADRL_BINARY_DIR) + "/bin/dadrl-replay tool snapshot --json --name now --run-dir " + run)
          .c_str(),
      "r");
  ASSERT_TRUE(actor_->PumpUntilStored(3000, 60.0)) << replay_->Log();
  std::string said;
  for (int c = std::fgetc(asking); c != EOF; c = std::fgetc(asking)) said += static_cast<char>(c);
  ASSERT_EQ(pclose(asking), 0) << said;
  EXPECT_EQ(nlohmann::json::parse(said)["done"], true);
  const std::string snapshot = run + "/snapshots/shard-0/now";
  EXPECT_EQ(RunTool({"verify", snapshot}).exit_code, 0);
  const auto held = nlohmann::json::parse(RunTool({"inspect", snapshot, "--json"}).out);
  EXPECT_GE(held["chunks"], 50);
  EXPECT_LE(held["chunks"], 3000);
  const ToolOutput taken = RunTool({"snapshot", "--name", "now", "--run-dir", run});
  EXPECT_EQ(taken.exit_code, 1);
  EXPECT_THAT(taken.err, testing::HasSubstr("exists"));
}

TEST_F(LiveTools, TheLimiterChangesWhileBothSidesWaitAndKeepsThatOverAKill) {
  config_.replay.max_times_sampled = 0;
  config_.replay.min_size = 1000;
  Launch();
  AddChunks(20);
  ASSERT_TRUE(actor_->PumpUntilStored(20)) << replay_->Log();
  const uint64_t number = learner_->Ask(8);
  ASSERT_TRUE(Eventually([&] { return !learner_->RepliesTo(number).empty(); }));
  EXPECT_TRUE(learner_->RepliesTo(number).back().bytes.empty()) << "80 frames are fewer than 1000";
  const std::string run = (folder_.path() / "run").string();
  const ToolOutput changed = RunTool({"limit", "--min-size", "8", "--run-dir", run});
  EXPECT_EQ(changed.exit_code, 0) << changed.err;
  EXPECT_THAT(changed.out, testing::HasSubstr("from 8 frames on"));
  ASSERT_TRUE(Eventually([&] { return !learner_->RepliesTo(number).back().bytes.empty(); }))
      << replay_->Log();
  const ToolOutput both =
      RunTool({"limit", "--samples-per-insert", "3", "--min-samples-per-insert", "4", "--run-dir", run});
  EXPECT_EQ(both.exit_code, 1);
  EXPECT_THAT(both.err, testing::HasSubstr("both sides would wait"));
  replay_->Kill();
  ASSERT_TRUE(learner_->WaitForNoReplay());
  replay_->Start();
  ASSERT_TRUE(learner_->WaitForReplay());
  EXPECT_FALSE(learner_->Fetch(8).bytes.empty());
}

TEST_F(LiveTools, HalfASnapshotOfAKilledReplayIsGoneAfterItsNextStart) {
  const std::filesystem::path half =
      folder_.path() / "run" / "snapshots" / "shard-0" / "20260101T000000Z.partial";
  std::filesystem::create_directories(half);
  std::ofstream(half / "segment-000000000001.log") << "of a replay that has dropped it";
  Launch();
  EXPECT_FALSE(std::filesystem::exists(half));
}

TEST_F(LiveTools, SnapshotsThatHoldMoreThanTheReplayItselfMayAreReportedWithTheRemedy) {
  constexpr uint64_t kBound = 1 << 20;
  config_.replay.max_disk_bytes = kBound;
  config_.replay.segment_bytes = kBound / 4;
  config_.telemetry.interval_s = 0.1;
  const std::filesystem::path run = folder_.path() / "run";
  const std::filesystem::path snapshots = run / "snapshots" / "shard-0";
  const std::filesystem::path segment = snapshots / "old" / "segment-000000000001.log";
  std::filesystem::create_directories(segment.parent_path());
  std::ofstream(segment) << "of a replay that has dropped it";
  std::filesystem::resize_file(segment, kBound);
  Launch();
  const auto telemetry = TelemetrySubscriber::Create(TelemetryUrl(config_.cluster)).value();
  double told = 0.0;
  EXPECT_TRUE(Eventually([&] {
    const auto hear = [&](const ProcessStatus& status) { told = status[Metric::kSnapshotBytes]; };
    telemetry->Poll(std::chrono::milliseconds(100), hear, {});
    return told == kBound;
  })) << told;
  // Once the second is answered, what was due before the first is done.
  for (int i = 0; i < 2; ++i) {
    const ToolOutput limit =
        RunTool({"limit", "--min-size", std::to_string(5 + i), "--run-dir", run.string()});
    ASSERT_EQ(limit.exit_code, 0) << limit.err << replay_->Log();
  }
  EXPECT_THAT(replay_->Log(), testing::Not(testing::HasSubstr("snapshots hold"))) << "just the bound";
  ASSERT_EQ(replay_->Terminate(), 0) << replay_->Log();
  std::filesystem::resize_file(segment, kBound + 1);
  replay_->Start();
  const std::string warning = fmt::format(
      "shard 0: 1 snapshots hold {} bytes that the replay has dropped, more than its own "
      "replay.max_disk_bytes of {}; remove those you do not need from {}, or keep fewer automatic ones "
      "(replay.snapshots_kept, now {}); the disk may become full\n",
      kBound + 1, kBound, snapshots.string(), config_.replay.snapshots_kept);
  EXPECT_TRUE(Eventually([&] { return replay_->Log().find(warning) != std::string::npos; }))
      << replay_->Log();
}

}  // namespace
}  // namespace dadrl
