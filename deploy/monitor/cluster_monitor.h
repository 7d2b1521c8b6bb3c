// A ClusterView that feeds itself from the cluster's telemetry.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/monitor/cluster_view.h"

namespace dadrl {

// Not thread safe. LCM and DDS start threads of their own: block signals before Open.
class ClusterMonitor {
 public:
  // `key`: the run's, or "". kUnavailable when telemetry is off.
  static Result<std::unique_ptr<ClusterMonitor>> Open(const Config& config, const std::string& key,
                                                      const Clock& clock);

  // Takes in what arrives within `timeout`; zero: what is there.
  void Poll(Duration timeout);

  // With what was refused of telemetry itself, by kind ("telemetry: fragment").
  ClusterSummary Summarize() const;
  int ReportingProcesses() const { return view_.ReportingProcesses(clock_.Now()); }

 private:
  ClusterMonitor(std::unique_ptr<TelemetrySubscriber> subscriber, double interval_s, const Clock& clock);

  std::unique_ptr<TelemetrySubscriber> subscriber_;
  const Clock& clock_;
  ClusterView view_;
  uint64_t surplus_ = 0;  // packets of one process more than a cluster can have
};

}  // namespace dadrl
