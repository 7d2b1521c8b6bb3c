#include "deploy/monitor/cluster_monitor.h"

#include <utility>

namespace dadrl {

Result<std::unique_ptr<ClusterMonitor>> ClusterMonitor::Open(const Config& config, const Clock& clock,
                                                             Listeners listeners) {
  if (!config.telemetry.enabled) return Fail(ErrorCode::kUnavailable, "telemetry.enabled is false");
  DADRL_ASSIGN_OR_RETURN(auto subscriber, TelemetrySubscriber::Create(config));
  return std::unique_ptr<ClusterMonitor>(
      new ClusterMonitor(std::move(subscriber), config.telemetry.interval_s, clock, std::move(listeners)));
}

ClusterMonitor::ClusterMonitor(std::unique_ptr<TelemetrySubscriber> subscriber, double interval_s,
                               const Clock& clock, Listeners listeners)
    : subscriber_(std::move(subscriber)),
      clock_(clock),
      listeners_(std::move(listeners)),
      view_(ClusterView::ForInterval(interval_s)) {}

void ClusterMonitor::Poll(Duration timeout) {
  subscriber_->Poll(
      timeout,
      [this](const ProcessStatus& status) {
        view_.Add(status, clock_.Now());
        if (listeners_.on_status) listeners_.on_status(status);
      },
      [this](const EpisodeReport& report) { view_.Add(report); });
}

}  // namespace dadrl
