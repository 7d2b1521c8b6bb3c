// The live panel of a training, as text.
#pragma once

#include <string>
#include <vector>

#include "deploy/monitor/cluster_view.h"
#include "deploy/monitor/text_columns.h"

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

// The panel, with its processes where they are asked for: at most `size.rows` lines, none wider than
// `size.columns`. What matters least is left out first.
std::vector<std::string> RenderPanel(const Progress& progress, TerminalSize size);
// What matters most as one plain line, for logs.
std::string RenderLine(const Progress& progress, size_t columns);

// 3725 -> "1:02:05".
std::string FormatTime(double seconds);

}  // namespace dadrl
