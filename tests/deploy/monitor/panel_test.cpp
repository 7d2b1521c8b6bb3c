#include "deploy/monitor/panel.h"

#include <gmock/gmock.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>
#include <limits>
#include <regex>
#include <sstream>

#include "deploy/monitor/monitor_json.h"
#include "deploy/monitor/process_lines.h"
#include "deploy/monitor/progress_display.h"

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
  for (const std::string& line : RenderPanel(Sample(), {})) text += line + "\n";
  EXPECT_THAT(text, HasSubstr("3:12 of 20:00"));
  EXPECT_THAT(text, HasSubstr("4,321 updates"));
  EXPECT_THAT(text, HasSubstr("success 63 %"));
  EXPECT_THAT(text, HasSubstr("learner: it computes 97 %"));
}

TEST(Panel, ShowsScenariosApartWhenThereAreSeveral) {
  Progress progress = Sample();
  progress.summary.recent_scenarios["left_turn"] = {60, 0.95};
  EXPECT_EQ(RenderPanel(progress, {}).size(), RenderPanel(Sample(), {}).size());
  progress.summary.recent_scenarios["double_merge"] = {40, 0.5};
  EXPECT_THAT(RenderPanel(progress, {}),
              testing::Contains(HasSubstr("double_merge 50 % of 40, left_turn 95 % of 60")));
  EXPECT_EQ(MonitorJson(progress.summary, "")["recent_episodes"]["scenarios"]["left_turn"]["count"], 60);
}

TEST(Panel, ShowsWhateverScalarsTheAlgorithmReports) {
  Progress progress = Sample();
  EXPECT_THAT(RenderPanel(progress, {}), Not(testing::Contains(HasSubstr("  training    "))));
  progress.summary.scalars = {{"clip_fraction", 0.125}, {"value_loss", 1234.5}};
  EXPECT_THAT(RenderPanel(progress, {}),
              testing::Contains("  training    clip fraction 0.125, value loss 1.23e+03"));
}

// As many lines as there can be, each longer than any terminal here.
Progress Busy(int actors) {
  Progress progress = Sample();
  progress.title = "dadrl monitor left_turn  (" + std::string(300, 'r') + ")";
  progress.phase += std::string(300, '.');
  progress.bottleneck += std::string(300, '.');
  progress.last_evaluation = std::string(300, 'e');
  progress.faults.assign(9, std::string(300, 'f'));
  progress.show_processes = true;
  ClusterSummary& s = progress.summary;
  s.snapshot_bytes = 1e9;
  s.scalars.assign(16, {std::string(23, 's'), 1.0});
  s.rejected = {{std::string(300, 'k'), 2}};
  s.recent_scenarios = {{std::string(300, 'a'), {60, 0.95}}, {"übergang", {60, 0.95}}};
  const auto add = [&](dds::Role role, int index, const std::string& name) {
    ProcessRow& row = s.processes.emplace_back();
    row.role = role;
    row.index = index;
    row.name = name;
    row.steps_per_s = 100.0;
    s.waits.push_back({name, std::string(300, 'w'), 0.5, {1, 1.0}});
  };
  add(dds::Role::kLearner, 0, "learner");
  add(dds::Role::kReplay, 0, "replay-0");
  for (int i = 0; i < actors; ++i) add(dds::Role::kActor, i, fmt::format("actor-{}", i));
  return progress;
}

class PanelSize : public testing::TestWithParam<TerminalSize> {};

TEST_P(PanelSize, IsNeverExceeded) {
  const TerminalSize size = GetParam();
  for (const int actors : {1, 100}) {
    const auto lines = RenderPanel(Busy(actors), size);
    EXPECT_LE(lines.size(), size.rows);
    EXPECT_GE(lines.size(), std::min<size_t>(size.rows, 19));  // and is used
    for (const std::string& line : lines) EXPECT_LE(CountColumns(line), size.columns) << line;
    EXPECT_THAT(lines, testing::Contains(HasSubstr("3:12 of 20:00")));
  }
}

INSTANTIATE_TEST_SUITE_P(, PanelSize,
                         testing::Values(TerminalSize{24, 80}, TerminalSize{10, 80}, TerminalSize{5, 40},
                                         TerminalSize{60, 200}, TerminalSize{1, 30}));

TEST(Panel, ShowsTheFirstFaultsAndCountsTheOthers) {
  Progress progress = Sample();
  progress.faults = {"actor-0: silent", "actor-1: silent", "actor-2: silent", "actor-3: silent",
                     "actor-4: silent"};
  const auto lines = RenderPanel(progress, {.rows = 5});
  EXPECT_THAT(lines, testing::ElementsAre(HasSubstr("time"), "  fault       actor-0: silent",
                                          "  fault       actor-1: silent", "  fault       actor-2: silent",
                                          "  fault       and 2 more"));
}

TEST(Panel, SaysWhatIsWrongWithAProcessAndHowOftenItHung) {
  ClusterSummary summary;
  ProcessRow& row = summary.processes.emplace_back();
  row.name = "replay-0";
  row.stale = true;
  row.trouble = "starts again: it hung";
  row.restarts = 3;
  row.hangs = 2;
  EXPECT_THAT(RenderProcesses(summary, {5, 200}),
              testing::ElementsAre(HasSubstr(", starts again: it hung, restarted 3x (2x hung)")));
  const auto json = MonitorJson(summary, "")["processes"][0];
  EXPECT_EQ(json["trouble"], "starts again: it hung");
  EXPECT_EQ(json["hangs"], 2);
}

TEST(Panel, LeavesOutWhatMattersLeastFirst) {
  std::string text;
  for (const std::string& line : RenderPanel(Sample(), {5, 80})) text += line + "\n";
  for (const char* kept : {"  time ", "  bottleneck ", "  learner ", "  last 100", "  actors "}) {
    EXPECT_THAT(text, HasSubstr(kept));
  }
  EXPECT_THAT(text, Not(HasSubstr("  weights ")));
}

TEST(Panel, SumsUpTheProcessesThatHaveNoRoom) {
  Progress progress = Busy(100);
  progress.summary.processes[50].stale = true;
  progress.summary.processes[60].stale = true;
  EXPECT_THAT(RenderProcesses(progress.summary, {3, 40}),
              testing::ElementsAre(testing::StartsWith("  actor-48 "), testing::StartsWith("  actor-58 "),
                                   "  and 1 replay, 100.0/s; 1 learner, 100."));
  EXPECT_THAT(RenderProcesses(progress.summary, {1, 200}),
              testing::ElementsAre("  and 1 replay, 100.0/s; 1 learner, 100.0/s; 100 actors, 10000.0/s, "
                                   "2 SILENT"));
  EXPECT_EQ(RenderProcesses(progress.summary, {102, 80}).size(), 102u);
}

TEST(TextColumns, CountsAndCutsCharacters) {
  EXPECT_EQ(CountColumns("über"), 4u);
  EXPECT_EQ(ClipColumns("über", 1), "ü");
  EXPECT_EQ(ClipColumns("über", 9), "über");
  EXPECT_EQ(ShortenColumns("Überholspur", 8), "Überh...");
  EXPECT_EQ(ShortenColumns("Überholspur", 11), "Überholspur");
  EXPECT_EQ(ClipColumns("a\x1b[2J\xc2\x9b\x7f", 20), "a?[2J??");
}

TEST(Panel, ALineForALogIsShort) {
  Progress progress = Busy(1);
  progress.phase = "training and evaluating";
  EXPECT_THAT(RenderLine(progress, 119), testing::EndsWith("..."));
  EXPECT_EQ(CountColumns(RenderLine(progress, 119)), 119u);
}

TEST(Panel, NamesEachFaultAndItsCause) {
  Progress progress = Sample();
  progress.summary.faults = {{"replay-0", {FaultKind::kExperience, "cannot write x: No space left", 95.0}},
                             {"learner", {FaultKind::kTrainingLog, "cannot write y: No space left", 3.0}}};
  const std::vector<std::string> lines = RenderPanel(progress, {24, 200});
  EXPECT_THAT(lines, testing::Contains(HasSubstr("fault       replay-0 for 1:35: cannot write x: No space")));
  EXPECT_THAT(lines, testing::Contains(HasSubstr("fault       learner for 0:03: cannot write y")));
  EXPECT_THAT(RenderLine(progress, 200), HasSubstr("faults: replay-0 experience, learner training_log | "));
  const auto faults = MonitorJson(progress.summary, "")["faults"];
  ASSERT_EQ(faults.size(), 2u);
  EXPECT_EQ(faults[0]["process"], "replay-0");
  EXPECT_EQ(faults[0]["kind"], "experience");
  EXPECT_EQ(faults[0]["text"], "cannot write x: No space left");
  EXPECT_EQ(faults[0]["since_s"], 95.0);
  EXPECT_EQ(MonitorJson(Sample().summary, "")["faults"].dump(), "[]");
}

TEST(Panel, ShowsWhatWasRejectedByKindOnceThereIsSomething) {
  Progress progress = Sample();
  EXPECT_THAT(RenderPanel(progress, {}), testing::Not(testing::Contains(HasSubstr("rejected"))));
  progress.summary.rejected = {{"wrong checksum", 2}, {"duplicate", 1234}};
  EXPECT_THAT(RenderPanel(progress, {}),
              testing::Contains(HasSubstr("rejected    1,234 duplicate, 2 wrong checksum")));
  EXPECT_EQ(MonitorJson(progress.summary, "")["rejected"]["duplicate"], 1234.0);
  EXPECT_TRUE(MonitorJson({}, "")["rejected"].empty());
}

TEST(RenderPanel, SaysWhatSnapshotsHoldWhenTheyHoldAnything) {
  Progress progress = Sample();
  EXPECT_THAT(RenderPanel(progress, {}), testing::Not(testing::Contains(HasSubstr("snapshots"))));
  progress.summary.snapshot_bytes = 12.5e6;
  EXPECT_THAT(RenderPanel(progress, {}),
              testing::Contains(HasSubstr("snapshots   12.5 MB in files of their own")));
  EXPECT_EQ(MonitorJson(progress.summary, "")["snapshot_bytes"], 12'500'000);
}

TEST(Panel, SaysHowOftenAndHowLongEachProcessWaitedForWhat) {
  ClusterSummary summary;
  summary.processes.emplace_back().name = "replay-0";
  summary.waits.push_back({"replay-0", "credits", 0.75, {12345, 61.25}});
  summary.waits.push_back({"replay-0", "disk", 0.0, {2, 0.125}});
  summary.waits.push_back({"learner", "inserts", 0.0, {1, 1.0}});
  EXPECT_THAT(RenderProcesses(summary, {}),
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

// A terminal of this size, and what was written to it.
class PseudoTerminal {
 public:
  PseudoTerminal(unsigned short rows, unsigned short columns) {
    const winsize size = Size(rows, columns);
    EXPECT_EQ(openpty(&master_, &slave_, nullptr, nullptr, &size), 0);
    stream_ = fdopen(slave_, "w");
  }
  ~PseudoTerminal() {
    std::fclose(stream_);
    close(master_);
  }
  PseudoTerminal(const PseudoTerminal&) = delete;
  PseudoTerminal& operator=(const PseudoTerminal&) = delete;
  std::FILE* stream() const { return stream_; }
  void Resize(unsigned short rows, unsigned short columns) const {
    const winsize size = Size(rows, columns);
    EXPECT_EQ(ioctl(master_, TIOCSWINSZ, &size), 0);
  }
  // Since the last call, to the end of what was shown: a terminal hands it over in pieces.
  std::string Written() const {
    std::string text;
    std::array<char, 4096> piece{};
    while (!text.ends_with("\x1b[?7h")) {
      const ssize_t bytes = read(master_, piece.data(), piece.size());
      if (bytes <= 0) break;
      text.append(piece.data(), static_cast<size_t>(bytes));
    }
    return text;
  }

 private:
  static winsize Size(unsigned short rows, unsigned short columns) {
    return {.ws_row = rows, .ws_col = columns, .ws_xpixel = 0, .ws_ypixel = 0};
  }
  int master_ = -1;
  int slave_ = -1;
  std::FILE* stream_ = nullptr;
};

TEST(ProgressDisplay, StaysInsideATerminalOfTenRowsAndOneThatBecomesNarrower) {
  const PseudoTerminal terminal(10, 80);
  const ManualClock clock;
  ProgressDisplay display(terminal.stream(), clock);
  display.Show(Busy(100));
  const std::string first = terminal.Written();
  EXPECT_EQ(std::count(first.begin(), first.end(), '\n'), 9);  // the tenth row is the cursor's
  display.Show(Sample());                                      // back over all of it
  EXPECT_THAT(terminal.Written(), testing::StartsWith("\x1b[9F"));
  size_t broken = 0;
  for (const std::string& line : RenderPanel(Sample(), {9, 80})) broken += (CountColumns(line) + 19) / 20;
  ASSERT_GT(broken, 9u);
  terminal.Resize(50, 20);  // it breaks each of its nine lines into several
  display.Show(Sample());
  const std::string narrow = terminal.Written();
  EXPECT_THAT(narrow, testing::StartsWith(fmt::format("\x1b[{}F", broken)));
  std::istringstream lines(std::regex_replace(narrow, std::regex("\x1b\\[[?0-9]*[A-Za-z]|\r"), ""));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(CountColumns(line), 20u) << line;
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
  summary.scalars = {
      {"critic_loss", 0.5}, {"temperature", 0.25}, {"temperature_loss", -1.0}, {"mean_q", 2.0}};
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
  EXPECT_EQ(json["losses"].dump(),
            R"({"critic":0.5,"temperature":0.25,"temperature_loss":-1.0,"mean_q":2.0})");
  summary.scalars = {{"critic_loss", std::numeric_limits<double>::quiet_NaN()}};
  EXPECT_EQ(nlohmann::json::parse(MonitorJson(summary, "").dump())["losses"]["critic"], 0.0);
}

}  // namespace
}  // namespace dadrl
