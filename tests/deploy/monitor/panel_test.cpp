#include "deploy/monitor/panel.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <limits>
#include <sstream>

#include "deploy/monitor/monitor_json.h"

namespace dadrl {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Progress Sample() {
  Progress progress;
  progress.title = "dadrl train left_turn";
  progress.phase = "training";
  progress.elapsed_s = 192;
  progress.total_s = 1200;
  progress.summary.updates = 4321;
  progress.summary.recent_episodes = 100;
  progress.summary.recent_success = 0.63;
  progress.bottleneck = "learner: it computes 97 % of its time";
  return progress;
}

TEST(Panel, ShowsWhereTheRunIs) {
  std::string text;
  for (const std::string& line : RenderPanel(Sample(), 120)) text += line + "\n";
  EXPECT_THAT(text, HasSubstr("3:12 of 20:00"));
  EXPECT_THAT(text, HasSubstr("4,321 updates"));
  EXPECT_THAT(text, HasSubstr("success 63 %"));
  EXPECT_THAT(text, HasSubstr("learner: it computes 97 %"));
}

TEST(Panel, ShowsScenariosApartWhenThereAreSeveral) {
  Progress progress = Sample();
  progress.summary.recent_scenarios["left_turn"] = {60, 0.95};
  EXPECT_EQ(RenderPanel(progress, 120).size(), RenderPanel(Sample(), 120).size());
  progress.summary.recent_scenarios["double_merge"] = {40, 0.5};
  EXPECT_THAT(RenderPanel(progress, 120),
              testing::Contains(HasSubstr("double_merge 50 % of 40, left_turn 95 % of 60")));
  EXPECT_EQ(MonitorJson(progress.summary, "")["recent_episodes"]["scenarios"]["left_turn"]["count"], 60);
}

TEST(Panel, NeverWrapsANarrowTerminal) {
  for (const std::string& line : RenderPanel(Sample(), 40)) EXPECT_LE(line.size(), 40u) << line;
}

TEST(Panel, ShowsWhatWasRejectedByKindOnceThereIsSomething) {
  Progress progress = Sample();
  EXPECT_THAT(RenderPanel(progress, 120), testing::Not(testing::Contains(HasSubstr("rejected"))));
  progress.summary.rejected = {{"wrong checksum", 2}, {"duplicate", 1234}};
  EXPECT_THAT(RenderPanel(progress, 120),
              testing::Contains(HasSubstr("rejected    1,234 duplicate, 2 wrong checksum")));
  EXPECT_EQ(MonitorJson(progress.summary, "")["rejected"]["duplicate"], 1234.0);
  EXPECT_TRUE(MonitorJson({}, "")["rejected"].empty());
}

TEST(RenderPanel, SaysWhatSnapshotsHoldWhenTheyHoldAnything) {
  Progress progress = Sample();
  EXPECT_THAT(RenderPanel(progress, 120), testing::Not(testing::Contains(HasSubstr("snapshots"))));
  progress.summary.snapshot_bytes = 12.5e6;
  EXPECT_THAT(RenderPanel(progress, 120),
              testing::Contains(HasSubstr("snapshots   12.5 MB in files of their own")));
  EXPECT_EQ(MonitorJson(progress.summary, "")["snapshot_bytes"], 12'500'000);
}

TEST(Panel, SaysHowOftenAndHowLongEachProcessWaitedForWhat) {
  ClusterSummary summary;
  summary.processes.emplace_back().name = "replay-0";
  summary.waits.push_back({"replay-0", "credits", 0.75, {12345, 61.25}});
  summary.waits.push_back({"replay-0", "disk", 0.0, {2, 0.125}});
  summary.waits.push_back({"learner", "inserts", 0.0, {1, 1.0}});
  EXPECT_THAT(RenderProcesses(summary, 200),
              testing::ElementsAre(testing::EndsWith("works   0 %, waits 75 % for credits (12,345x, 61.2 s)"
                                                     "; before: disk 2x, 0.1 s")));
}

TEST(Panel, FormatsTimes) {
  EXPECT_EQ(FormatTime(0), "0:00");
  EXPECT_EQ(FormatTime(61.9), "1:01");
  EXPECT_EQ(FormatTime(3725), "1:02:05");
}

TEST(ProgressDisplay, PrintsPlainLinesEveryTenSecondsWhereThereIsNoTerminal) {
  std::FILE* file = std::tmpfile();
  ASSERT_NE(file, nullptr);
  ManualClock clock;
  ProgressDisplay display(file, clock);
  int shown = 0;
  for (int i = 0; i < 250; ++i) {  // 25 s
    if (display.Due()) {
      display.Show(Sample());
      ++shown;
    }
    clock.Advance(std::chrono::milliseconds(100));
  }
  EXPECT_EQ(shown, 3);
  display.Message("actor-0 ended");
  std::rewind(file);
  std::string text(10000, '\0');
  text.resize(std::fread(text.data(), 1, text.size(), file));
  std::fclose(file);
  EXPECT_THAT(text, HasSubstr("[3:12 of 20:00] training"));
  EXPECT_THAT(text, HasSubstr("\nactor-0 ended\n"));
  EXPECT_THAT(text, Not(HasSubstr("\x1b")));
}

TEST(ProgressDisplay, OutlivesItsReader) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  close(ends[0]);
  const auto before = signal(SIGPIPE, SIG_IGN);
  std::FILE* stream = fdopen(ends[1], "w");
  setlinebuf(stream);
  SystemClock clock;
  {
    ProgressDisplay display(stream, clock);
    EXPECT_NO_THROW(display.Message("nobody reads this"));
    EXPECT_NO_THROW(display.Show(Sample()));
  }
  std::fclose(stream);
  signal(SIGPIPE, before);
}

TEST(MonitorJson, HasTheKeysThatScriptsRelyOn) {
  ClusterSummary summary;
  summary.env_steps_per_s = 512;
  summary.inserted_mb_per_s = 1.5;
  summary.sampled_mb_per_s = 3.0;
  summary.staleness_versions = {2.0, 7.0};
  summary.critic_loss = std::numeric_limits<double>::quiet_NaN();
  summary.waits.push_back({"learner", "inserts", 0.25, {12, 3.5}});
  const auto json = MonitorJson(summary, "none");
  for (const char* key : {"env_steps_per_s", "inserted_frames_per_s", "sampled_transitions_per_s", "mb_per_s",
                          "updates_per_s", "weights_version", "replay_frames", "replay_bytes",
                          "snapshot_bytes", "staleness_versions", "staleness_s", "waits", "bottleneck"}) {
    EXPECT_TRUE(json.contains(key)) << key;
  }
  EXPECT_EQ(json["mb_per_s"], 4.5);
  EXPECT_EQ(json["staleness_versions"]["max"], 7.0);
  EXPECT_EQ(json["waits"][0]["for"], "inserts");
  EXPECT_EQ(json["waits"][0]["count"], 12);
  EXPECT_EQ(json["waits"][0]["seconds"], 3.5);
  EXPECT_EQ(nlohmann::json::parse(json.dump())["losses"]["critic"], 0.0);
}

}  // namespace
}  // namespace dadrl
