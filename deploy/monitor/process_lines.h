// What each process of a cluster does, a line each.
#pragma once

#include <string>
#include <vector>

#include "deploy/monitor/cluster_view.h"
#include "deploy/monitor/text_columns.h"

namespace dadrl {

// One line a process: share of time working and waiting, how often and how long it waited for what, restarts.
// Where they are more than `size.rows`, silent ones are shown first, then the learner, replays, actors; the
// last line sums up the rest.
std::vector<std::string> RenderProcesses(const ClusterSummary& summary, TerminalSize size);

}  // namespace dadrl
