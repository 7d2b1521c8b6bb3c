#include "deploy/monitor/cluster_monitor.h"

#include <utility>

namespace dadrl {

Result<std::unique_ptr<ClusterMonitor>> ClusterMonitor::Open(const Config& config, const std::string& key,
                                                             const Clock& clock) {
  if (!config.telemetry.enabled) return Fail(ErrorCode::kUnavailable, "telemetry.enabled is false");
  DADRL_ASSIGN_OR_RETURN(auto subscriber, TelemetrySubscriber::Create(config, key));
  return std::unique_ptr<ClusterMonitor>(
      new ClusterMonitor(std::move(subscriber), config.telemetry.interval_s, clock));
}

ClusterMonitor::ClusterMonitor(std::unique_ptr<TelemetrySubscriber> subscriber, double interval_s,
                               const Clock& clock)
    : subscriber_(std::move(subscriber)), clock_(clock), view_(ClusterView::ForInterval(interval_s)) {}

void ClusterMonitor::Poll(Duration timeout) {
  subscriber_->Poll(
      timeout,
      [this](const ProcessStatus& status) {
        if (!view_.Add(status, clock_.Now())) ++surplus_;
      },
      [this](const EpisodeReport& report) { view_.Add(report); });
}

ClusterSummary ClusterMonitor::Summarize() const {
  ClusterSummary summary = view_.Summarize(clock_.Now());
  for (const auto& [kind, count] : subscriber_->refusals()) {
    summary.rejected["telemetry: " + kind] = count;
  }
  if (surplus_ > 0) summary.rejected["telemetry: too many processes"] = surplus_;
  return summary;
}

}  // namespace dadrl
