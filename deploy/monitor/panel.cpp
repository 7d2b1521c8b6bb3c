#include "deploy/monitor/panel.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "deploy/monitor/bottleneck.h"

namespace dadrl {
namespace {

constexpr double kPanelInterval_s = 0.5;
constexpr double kLineInterval_s = 10.0;

size_t TerminalWidth(std::FILE* stream) {
  winsize size{};
  if (ioctl(fileno(stream), TIOCGWINSZ, &size) != 0 || size.ws_col < 20) return 80;
  return size.ws_col;
}

// Cuts at `width` columns; all text here is ASCII.
std::string Clip(std::string line, size_t width) {
  if (line.size() > width) line.resize(width);
  return line;
}

std::string Time(const Progress& p) {
  if (p.total_s <= 0.0) return FormatTime(p.elapsed_s);
  return fmt::format("{} of {}", FormatTime(p.elapsed_s), FormatTime(p.total_s));
}

std::string Recent(const ClusterSummary& s) {
  if (s.recent_episodes == 0) return "no episode finished yet";
  return fmt::format(
      "success {:.0f} %  collision {:.0f} %  off-road {:.0f} %  stagnation {:.0f} %  return {:.2f}",
      100.0 * s.recent_success, 100.0 * s.recent_collision, 100.0 * s.recent_off_road,
      100.0 * s.recent_stagnation, s.recent_return);
}

// "double_merge 80 % of 19, left_turn 95 % of 21"
std::string RecentScenarios(const ClusterSummary& s) {
  std::string text;
  for (const auto& [name, rate] : s.recent_scenarios) {
    text += fmt::format("{}{} {:.0f} % of {}", text.empty() ? "" : ", ", name, 100.0 * rate.success,
                        rate.episodes);
  }
  return text;
}

// "5 duplicate, 2 wrong checksum"
std::string Rejected(const ClusterSummary& s) {
  std::string text;
  for (const auto& [kind, count] : s.rejected) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", Thousands(count), kind);
  }
  return text;
}

// ", waits 46 % for simulator (455x, 19.9 s); before: replay 1x, 0.1 s": first what it waits for now, with
// how often and how long since its start, then what it waited for earlier.
std::string Waits(const ClusterSummary& s, const std::string& process) {
  std::string now, before;
  for (const Wait& wait : s.waits) {
    if (wait.who != process) continue;
    const std::string spent =
        fmt::format("{}x, {:.1f} s", Thousands(static_cast<double>(wait.spent.count)), wait.spent.seconds);
    if (const double percent = std::round(100.0 * wait.fraction); percent > 0.0) {
      now += fmt::format(", waits {:.0f} % for {} ({})", percent, wait.for_what, spent);
    } else {
      before += fmt::format("; before: {} {}", wait.for_what, spent);
    }
  }
  return now + before;
}

}  // namespace

std::string FormatTime(double seconds) {
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::vector<std::string> RenderPanel(const Progress& progress, size_t width) {
  const ClusterSummary& s = progress.summary;
  std::vector<std::string> lines;
  lines.push_back(progress.title);
  lines.push_back(fmt::format("  time        {}  {}", Time(progress), progress.phase));
  for (const std::string& fault : progress.faults) lines.push_back("  fault       " + fault);
  lines.push_back(fmt::format("  actors      {} alive, {:.0f} env steps/s, {} steps, {} episodes",
                              s.actors_alive, s.env_steps_per_s, Thousands(s.env_steps),
                              Thousands(s.episodes)));
  lines.push_back(
      fmt::format("  replay      {} frames, {:.1f} MB, {:.0f} inserted/s, {:.0f} sampled/s, {:.1f} MB/s",
                  Thousands(s.replay_frames), s.replay_bytes / 1e6, s.inserted_frames_per_s,
                  s.sampled_transitions_per_s, s.inserted_mb_per_s + s.sampled_mb_per_s));
  if (s.snapshot_bytes > 0.0) {
    lines.push_back(fmt::format("  snapshots   {:.1f} MB in files of their own", s.snapshot_bytes / 1e6));
  }
  if (!s.rejected.empty()) lines.push_back("  rejected    " + Rejected(s));
  lines.push_back(
      fmt::format("  learner     {} updates, {:.1f} updates/s, critic loss {:.3g}, temperature {:.3g}",
                  Thousands(s.updates), s.updates_per_s, s.critic_loss, s.temperature));
  lines.push_back(
      fmt::format("  weights     version {:.0f}, staleness mean {:.1f} max {:.0f} versions, "
                  "mean {:.1f} max {:.0f} s",
                  s.weights_version, s.staleness_versions.mean, s.staleness_versions.max, s.staleness_s.mean,
                  s.staleness_s.max));
  lines.push_back(fmt::format("  last {:<6} {}",
                              s.recent_episodes > 0 ? std::to_string(s.recent_episodes) : "", Recent(s)));
  if (s.recent_scenarios.size() > 1) lines.push_back("  success     " + RecentScenarios(s));
  lines.push_back("  evaluation  " +
                  (progress.last_evaluation.empty() ? "none yet" : progress.last_evaluation));
  lines.push_back("  bottleneck  " + progress.bottleneck);
  for (std::string& line : lines) line = Clip(std::move(line), width);
  return lines;
}

std::string RenderLine(const Progress& progress) {
  const ClusterSummary& s = progress.summary;
  return fmt::format(
      "[{}] {} | {:.0f} env steps/s, {:.0f} frames/s, {:.1f} updates/s, {} updates, weights {:.0f}, "
      "staleness {:.1f} | last {}: success {:.0f} %, collision {:.0f} % | {}",
      Time(progress), progress.phase, s.env_steps_per_s, s.inserted_frames_per_s, s.updates_per_s,
      Thousands(s.updates), s.weights_version, s.staleness_versions.mean, s.recent_episodes,
      100.0 * s.recent_success, 100.0 * s.recent_collision, progress.bottleneck);
}

std::vector<std::string> RenderProcesses(const ClusterSummary& summary, size_t width) {
  size_t name_width = 0;
  for (const ProcessRow& row : summary.processes) name_width = std::max(name_width, row.name.size());
  std::vector<std::string> lines;
  for (const ProcessRow& row : summary.processes) {
    std::string line =
        fmt::format("  {:<{}} pid {:<8} up {:<8} {:>7.1f}/s  works {:>3.0f} %", row.name, name_width, row.pid,
                    FormatTime(row.uptime_s), row.steps_per_s, 100.0 * row.Share(Activity::kWork));
    if (row.stale) line += fmt::format(", SILENT for {:.0f} s", row.silent_s);
    if (row.restarts > 0) line += fmt::format(", restarted {}x", row.restarts);
    line += Waits(summary, row.name);
    lines.push_back(Clip(std::move(line), width));
  }
  return lines;
}

ProgressDisplay::ProgressDisplay(std::FILE* stream, const Clock& clock)
    : stream_(stream), clock_(clock), terminal_(isatty(fileno(stream)) == 1), next_(clock.Now()) {}

ProgressDisplay::~ProgressDisplay() { Finish(); }

bool ProgressDisplay::Due() const { return clock_.Now() >= next_; }

// A terminal or pipe that is gone must not end the training: errors are ignored (fmt::print would throw).
void ProgressDisplay::Put(const std::string& text) { std::fwrite(text.data(), 1, text.size(), stream_); }

void ProgressDisplay::Erase() {
  // Up over the old panel, then clear to the end of the screen.
  if (shown_lines_ > 0) Put(fmt::format("\x1b[{}F\x1b[J", shown_lines_));
  shown_lines_ = 0;
}

void ProgressDisplay::Show(const Progress& progress) {
  next_ = clock_.Now() + FromSeconds(terminal_ ? kPanelInterval_s : kLineInterval_s);
  if (!terminal_) {
    Put(RenderLine(progress) + "\n");
    std::fflush(stream_);
    return;
  }
  const size_t width = TerminalWidth(stream_);
  std::vector<std::string> lines = RenderPanel(progress, width);
  if (progress.show_processes) {
    const std::vector<std::string> processes = RenderProcesses(progress.summary, width);
    lines.insert(lines.end(), processes.begin(), processes.end());
  }
  Erase();
  for (const std::string& line : lines) Put(line + "\n");
  std::fflush(stream_);
  shown_lines_ = lines.size();
}

void ProgressDisplay::Message(const std::string& text) {
  Erase();
  Put(text + "\n");
  std::fflush(stream_);
  if (terminal_) next_ = clock_.Now();  // brings the panel back at once
}

void ProgressDisplay::Finish() { shown_lines_ = 0; }

}  // namespace dadrl
