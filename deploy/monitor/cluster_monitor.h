// A ClusterView that feeds itself from the cluster's telemetry.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"
#include "deploy/monitor/cluster_view.h"

namespace dadrl {

// Not thread safe. LCM and DDS start threads of their own: block signals before Open.
class ClusterMonitor {
 public:
  struct Listeners {
    std::function<void(const ProcessStatus&)> on_status;  // may be empty
  };

  // kUnavailable when telemetry is off.
  static Result<std::unique_ptr<ClusterMonitor>> Open(const Config& config, const Clock& clock,
                                                      Listeners listeners);

  // Takes in what arrives within `timeout`; zero: what is there.
  void Poll(Duration timeout);

  ClusterSummary Summarize() const { return view_.Summarize(clock_.Now()); }
  int ReportingProcesses() const { return view_.ReportingProcesses(clock_.Now()); }

 private:
  ClusterMonitor(std::unique_ptr<TelemetrySubscriber> subscriber, double interval_s, const Clock& clock,
                 Listeners listeners);

  std::unique_ptr<TelemetrySubscriber> subscriber_;
  const Clock& clock_;
  Listeners listeners_;
  ClusterView view_;
};

}  // namespace dadrl
