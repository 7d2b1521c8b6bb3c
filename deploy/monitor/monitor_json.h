// The monitor's answer for scripts: keys that stay (README, "Commands").
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "deploy/monitor/cluster_view.h"

namespace dadrl {

nlohmann::ordered_json MonitorJson(const ClusterSummary& summary, const std::string& bottleneck);

}  // namespace dadrl
