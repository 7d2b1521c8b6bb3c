#include "deploy/monitor/merge_supervision.h"

#include <algorithm>
#include <charconv>
#include <optional>

namespace dadrl {
namespace {

// "actor-3" is actor 3; nothing for what is no process of a cluster (the launcher).
std::optional<ProcessRow> NamedRow(const std::string& name) {
  for (const dds::Role role : {dds::Role::kLearner, dds::Role::kReplay, dds::Role::kActor}) {
    const std::string role_name = RoleName(role);
    if (!name.starts_with(role_name)) continue;
    ProcessRow row{.name = name, .role = role, .stale = true};
    const char* const end = name.data() + name.size();
    std::from_chars(std::min(name.data() + role_name.size() + 1, end), end, row.index);
    return row;
  }
  return std::nullopt;
}

void Merge(const SupervisedProcess& process, ProcessRow& row) {
  row.state = process.state;
  row.trouble = process.trouble;
  row.hangs = process.hangs;
  row.restarts = std::max(row.restarts, process.restarts);
  if (process.pid > 0) row.pid = process.pid;
}

}  // namespace

void MergeSupervision(const Supervision& supervision, ClusterSummary& summary) {
  for (const SupervisedProcess& process : supervision.processes) {
    const auto known = std::find_if(summary.processes.begin(), summary.processes.end(),
                                    [&](const ProcessRow& row) { return row.name == process.name; });
    if (known != summary.processes.end()) {
      Merge(process, *known);
    } else if (std::optional<ProcessRow> row = NamedRow(process.name)) {
      Merge(process, *row);
      if (row->trouble.empty()) row->trouble = "not heard";
      summary.processes.push_back(std::move(*row));
    }
  }
}

}  // namespace dadrl
