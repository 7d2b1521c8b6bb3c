#include "actor/collect/status_reporter.h"

#include <algorithm>
#include <utility>

namespace dadrl {
namespace {

// Between two looks at whom it waits for.
constexpr Duration kLookInterval = std::chrono::milliseconds(250);

}  // namespace

StatusReporter::StatusReporter(TelemetryPublisher& publisher, const TelemetryConfig& telemetry,
                               const StatusEnvelope& envelope, const Clock& clock, Source source)
    : publisher_(publisher),
      status_interval_(FromSeconds(telemetry.interval_s)),
      envelope_(envelope),
      clock_(clock),
      source_(std::move(source)),
      next_status_(clock.Now()),
      thread_([this](bool last) {
        last ? PublishStatus() : Look();
        return std::min(kLookInterval, status_interval_);
      }) {}

void StatusReporter::Look() {
  const TimePoint now = clock_.Now();
  if (source_.on_look) source_.on_look();
  wait_notice_.Update(source_.waiting_for(), now);
  if (now < next_status_) return;
  next_status_ = now + status_interval_;
  PublishStatus();
}

void StatusReporter::PublishStatus() {
  ProcessStatus status = envelope_.Begin();
  source_.fill(status);
  publisher_.Publish(status);
}

}  // namespace dadrl
