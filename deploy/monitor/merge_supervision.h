// What the launcher knows and what the processes say of themselves, in one view.
#pragma once

#include "deploy/monitor/cluster_view.h"
#include "deploy/monitor/supervision.h"

namespace dadrl {

// Adds state, trouble and restarts to the rows of `summary`, and a row for each process that was never heard.
void MergeSupervision(const Supervision& supervision, ClusterSummary& summary);

}  // namespace dadrl
