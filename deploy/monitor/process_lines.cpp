#include "deploy/monitor/process_lines.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <span>

#include "deploy/monitor/bottleneck.h"
#include "deploy/monitor/panel.h"

namespace dadrl {
namespace {

// ", waits 46 % for simulator (455x, 19.9 s); before: replay 1x, 0.1 s": first what it waits for now, with
// how often and how long since its start, then what it waited for earlier.
std::string Waits(const ClusterSummary& s, const std::string& process) {
  std::string now, before;
  for (const Wait& wait : s.waits) {
    if (wait.who != process) continue;
    const std::string spent = fmt::format("{}x, {:.1f} s", Thousands(wait.spent.count), wait.spent.seconds);
    if (const double percent = std::round(100.0 * wait.fraction); percent > 0.0) {
      now += fmt::format(", waits {:.0f} % for {} ({})", percent, wait.for_what, spent);
    } else {
      before += fmt::format("; before: {} {}", wait.for_what, spent);
    }
  }
  return now + before;
}

std::string ProcessLine(const ClusterSummary& summary, const ProcessRow& row, size_t name_width) {
  std::string line =
      fmt::format("  {:<{}} pid {:<8} up {:<8} {:>7.1f}/s  works {:>3.0f} %", row.name, name_width, row.pid,
                  FormatTime(row.uptime_s), row.steps_per_s, 100.0 * row.Share(Activity::kWork));
  if (!row.trouble.empty()) {
    line += ", " + row.trouble;
  } else if (row.stale) {
    line += fmt::format(", SILENT for {:.0f} s", row.silent_s);
  }
  if (row.restarts > 0) line += fmt::format(", restarted {}x", row.restarts);
  if (row.hangs > 0) line += fmt::format(" ({}x hung)", row.hangs);
  return line + Waits(summary, row.name);
}

// "  and 35 actors, 71,234.5/s, 2 SILENT": what had no line of its own.
std::string SumLine(std::span<const ProcessRow* const> rows) {
  struct Sum {
    int processes = 0;
    int silent = 0;
    double steps_per_s = 0.0;
  };
  std::map<dds::Role, Sum> sums;
  for (const ProcessRow* row : rows) {
    Sum& sum = sums[row->role];
    ++sum.processes;
    sum.silent += row->stale ? 1 : 0;
    sum.steps_per_s += row->steps_per_s;
  }
  std::string line;
  for (const auto& [role, sum] : sums) {
    line += fmt::format("{}{} {}{}, {:.1f}/s", line.empty() ? "  and " : "; ", sum.processes, RoleName(role),
                        sum.processes == 1 ? "" : "s", sum.steps_per_s);
    if (sum.silent > 0) line += fmt::format(", {} SILENT", sum.silent);
  }
  return line;
}

}  // namespace

std::vector<std::string> RenderProcesses(const ClusterSummary& summary, TerminalSize size) {
  size_t name_width = 0;
  std::vector<const ProcessRow*> rows;
  for (const ProcessRow& row : summary.processes) {
    name_width = std::max(name_width, row.name.size());
    rows.push_back(&row);
  }
  size_t shown = rows.size();
  if (rows.size() > size.rows) {
    shown = size.rows - std::min<size_t>(size.rows, 1);
    std::stable_sort(rows.begin(), rows.end(),
                     [](const ProcessRow* a, const ProcessRow* b) { return a->stale && !b->stale; });
  }
  std::vector<std::string> lines;
  for (const ProcessRow* row : std::span(rows).first(shown)) {
    lines.push_back(ClipColumns(ProcessLine(summary, *row, name_width), size.columns));
  }
  if (shown < rows.size() && size.rows > 0) {
    lines.push_back(ClipColumns(SumLine(std::span(rows).subspan(shown)), size.columns));
  }
  return lines;
}

}  // namespace dadrl
