// The live panel of a training, and how it gets onto a terminal.
#pragma once

#include <cstdio>
#include <string>
#include <vector>

#include "common/util/clock.h"
#include "deploy/monitor/cluster_view.h"

namespace dadrl {

struct Progress {
  std::string title;  // scenario and run directory
  std::string phase;  // "training", "waiting for 2,000 frames before training: 1,240 so far"
  double elapsed_s = 0.0;
  double total_s = 0.0;  // 0: until stopped
  ClusterSummary summary;
  std::string last_evaluation;  // empty: none yet
  std::string bottleneck;
  std::vector<std::string> faults;  // of single processes: "replay-0: silent for 3 s: stopped by a signal"
  bool show_processes = false;      // a line each, below
};

// The panel, a line each, none wider than `width` columns.
std::vector<std::string> RenderPanel(const Progress& progress, size_t width);
// The same as one plain line, for logs.
std::string RenderLine(const Progress& progress);
// One line a process: share of time working and waiting, how often and how long it waited for what, restarts.
std::vector<std::string> RenderProcesses(const ClusterSummary& summary, size_t width);

// 3725 -> "1:02:05".
std::string FormatTime(double seconds);

// Writes progress to a stream: on a terminal a panel that is redrawn in place twice a second, elsewhere a
// plain line every ten seconds. Not thread safe; nothing else should write to the same terminal meanwhile,
// messages go through Message.
class ProgressDisplay {
 public:
  // Borrows both.
  ProgressDisplay(std::FILE* stream, const Clock& clock);
  ~ProgressDisplay();
  ProgressDisplay(const ProgressDisplay&) = delete;
  ProgressDisplay& operator=(const ProgressDisplay&) = delete;

  // Whether enough time has passed to show something new.
  bool Due() const;
  void Show(const Progress& progress);
  // A line that stays: above the panel, or between the plain lines.
  void Message(const std::string& text);
  // Leaves the last panel where it is; further output goes below it.
  void Finish();

 private:
  void Put(const std::string& text);
  void Erase();

  std::FILE* stream_;
  const Clock& clock_;
  bool terminal_;
  size_t shown_lines_ = 0;
  TimePoint next_{};
};

}  // namespace dadrl
