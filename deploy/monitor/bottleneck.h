// Who holds the cluster up, in one sentence a user can act on.
#pragma once

#include <string>

#include "common/config/config.h"
#include "deploy/monitor/cluster_view.h"

namespace dadrl {

// Names the part that the others wait for, the evidence, and what would help.
std::string DescribeBottleneck(const ClusterSummary& summary, const Config& config);

// 1234567 -> "1,234,567".
std::string Thousands(double value);

}  // namespace dadrl
