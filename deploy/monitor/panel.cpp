#include "deploy/monitor/panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <numeric>

#include "deploy/monitor/bottleneck.h"
#include "deploy/monitor/process_lines.h"

namespace dadrl {
namespace {

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

// The lines of a panel, and which of them stay where there is not room for all.
struct Lines {
  struct Line {
    int rank;  // 0 stays longest
    std::string text;
  };
  std::vector<Line> all;

  void Add(int rank, std::string text) { all.push_back({rank, std::move(text)}); }
  std::vector<std::string> Fit(TerminalSize size) const {
    std::vector<size_t> by_rank(all.size());
    std::iota(by_rank.begin(), by_rank.end(), size_t{0});
    std::ranges::stable_sort(by_rank, {}, [this](size_t line) { return all[line].rank; });
    by_rank.resize(std::min(by_rank.size(), size.rows));
    std::ranges::sort(by_rank);
    std::vector<std::string> fitting;
    for (const size_t line : by_rank) fitting.push_back(ClipColumns(all[line].text, size.columns));
    return fitting;
  }
};

// "replay-0 for 0:35: cannot write ...; actors keep their experience until it can be stored"
std::string FaultText(const ProcessFault& fault) {
  return fmt::format("{} for {}: {}; {}", fault.process, FormatTime(fault.fault.since_s), fault.fault.text,
                     FaultMeaning(fault.fault.kind));
}

// What holds up a process reaches the launcher twice, by its page of memory and by telemetry: cut short, and
// whole.
bool IsShownWhole(const std::string& trouble, const std::vector<ProcessFault>& faults) {
  return std::ranges::any_of(faults, [&](const ProcessFault& fault) {
    return fmt::format("{}: {}", fault.process, fault.fault.text).starts_with(trouble);
  });
}

void AddFaults(const Progress& progress, Lines& lines) {
  std::vector<std::string> faults;
  for (const std::string& trouble : progress.faults) {
    if (!IsShownWhole(trouble, progress.summary.faults)) faults.push_back(trouble);
  }
  for (const ProcessFault& fault : progress.summary.faults) faults.push_back(FaultText(fault));
  constexpr size_t kMost = 3;
  for (size_t i = 0; i < std::min(faults.size(), kMost); ++i) lines.Add(1, "  fault       " + faults[i]);
  if (faults.size() > kMost) {
    lines.Add(1, fmt::format("  fault       and {} more", faults.size() - kMost));
  }
}

void AddReplay(const ClusterSummary& s, Lines& lines) {
  lines.Add(
      6, fmt::format("  replay      {} frames, {:.1f} MB, {:.0f} inserted/s, {:.0f} sampled/s, {:.1f} MB/s",
                     Thousands(s.replay_frames), s.replay_bytes / 1e6, s.inserted_frames_per_s,
                     s.sampled_transitions_per_s, s.inserted_mb_per_s + s.sampled_mb_per_s));
  if (s.snapshot_bytes > 0.0) {
    lines.Add(12, fmt::format("  snapshots   {:.1f} MB in files of their own", s.snapshot_bytes / 1e6));
  }
  if (!s.rejected.empty()) lines.Add(7, "  rejected    " + Rejected(s));
}

void AddLearner(const ClusterSummary& s, Lines& lines) {
  lines.Add(3, fmt::format("  learner     {} updates, {:.1f} updates/s, {} of processor time",
                           Thousands(s.updates), s.updates_per_s, FormatTime(s.learner_cpu_s)));
  if (!s.scalars.empty()) lines.Add(7, "  training    " + ScalarsText(s.scalars));
  lines.Add(10, fmt::format("  weights     version {:.0f}, staleness mean {:.1f} max {:.0f} versions, "
                            "mean {:.1f} max {:.0f} s",
                            s.weights_version, s.staleness_versions.mean, s.staleness_versions.max,
                            s.staleness_s.mean, s.staleness_s.max));
}

Lines PanelLines(const Progress& progress) {
  const ClusterSummary& s = progress.summary;
  Lines lines;
  lines.Add(8, progress.title);
  lines.Add(0, fmt::format("  time        {}  {}", Time(progress), progress.phase));
  AddFaults(progress, lines);
  lines.Add(5, fmt::format("  actors      {} alive, {:.0f} env steps/s, {} steps, {} episodes",
                           s.actors_alive, s.env_steps_per_s, Thousands(s.env_steps), Thousands(s.episodes)));
  AddReplay(s, lines);
  AddLearner(s, lines);
  lines.Add(4, fmt::format("  last {:<6} {}", s.recent_episodes > 0 ? std::to_string(s.recent_episodes) : "",
                           Recent(s)));
  if (s.recent_scenarios.size() > 1) lines.Add(11, "  success     " + RecentScenarios(s));
  lines.Add(9, "  evaluation  " + (progress.last_evaluation.empty() ? "none yet" : progress.last_evaluation));
  lines.Add(2, "  bottleneck  " + progress.bottleneck);
  return lines;
}

}  // namespace

std::string FormatTime(double seconds) {
  const auto whole = static_cast<long>(std::max(0.0, seconds));
  if (whole >= 3600) return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

std::vector<std::string> RenderPanel(const Progress& progress, TerminalSize size) {
  const Lines lines = PanelLines(progress);
  const size_t wanted = progress.show_processes ? progress.summary.processes.size() : 0;
  const size_t left = size.rows > lines.all.size() ? size.rows - lines.all.size() : 0;
  // Where there is not room for all, processes get a third.
  const size_t processes = std::min(wanted, std::max(left, size.rows / 3));
  std::vector<std::string> shown = lines.Fit({size.rows - processes, size.columns});
  if (processes > 0) {
    std::ranges::move(RenderProcesses(progress.summary, {processes, size.columns}),
                      std::back_inserter(shown));
  }
  return shown;
}

std::string RenderLine(const Progress& progress, size_t columns) {
  const ClusterSummary& s = progress.summary;
  // In front, and short: the messages between these lines tell more.
  std::string faults;
  for (const ProcessFault& fault : s.faults) {
    faults += fmt::format("{}{} {}", faults.empty() ? "faults: " : ", ", fault.process,
                          FaultName(fault.fault.kind));
  }
  if (!faults.empty()) faults += " | ";
  return ShortenColumns(
      fmt::format("[{}] {}{} | {} updates, {:.1f}/s | {:.0f} env steps/s | last {}: success "
                  "{:.0f} %, collision {:.0f} % | {}",
                  Time(progress), faults, progress.phase, Thousands(s.updates), s.updates_per_s,
                  s.env_steps_per_s, s.recent_episodes, 100.0 * s.recent_success, 100.0 * s.recent_collision,
                  progress.bottleneck),
      columns);
}

}  // namespace dadrl
