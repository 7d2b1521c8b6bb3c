#include "actor/collect/status_reporter.h"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "common/util/fault.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

// Between two looks at whom it waits for.
constexpr Duration kLookInterval = std::chrono::milliseconds(250);

TimePoint Now() { return SystemClock().Now(); }

}  // namespace

StatusReporter::StatusReporter(TelemetryPublisher& publisher, const TelemetryConfig& telemetry, int actor,
                               uint64_t incarnation, Source source)
    : publisher_(publisher),
      status_interval_(FromSeconds(telemetry.interval_s)),
      actor_(actor),
      incarnation_(incarnation),
      source_(std::move(source)),
      started_(Now()),
      next_status_(started_),
      thread_([this](bool last) {
        last ? PublishStatus(Now()) : Look(Now());
        return std::min(kLookInterval, status_interval_);
      }) {}

void StatusReporter::Look(TimePoint now) {
  if (source_.on_look) source_.on_look();
  wait_notice_.Update(source_.waiting_for(), now);
  if (now >= next_status_) PublishStatus(now);
}

void StatusReporter::PublishStatus(TimePoint now) {
  next_status_ = now + status_interval_;
  ProcessStatus status;
  status.role = dds::Role::kActor;
  status.index = actor_;
  status.pid = ::getpid();
  status.incarnation = incarnation_;
  status.sent_ns = WallTimeNs();
  status.uptime_s = ToSeconds(now - started_);
  status.faults = ProcessFaults().Current();
  source_.fill(status);
  publisher_.Publish(status);
}

}  // namespace dadrl
