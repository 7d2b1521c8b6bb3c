// What an actor tells the world beside its loop: its status, and whom it waits for.
#pragma once

#include <functional>
#include <string>

#include "actor/collect/wait_notice.h"
#include "common/util/background_thread.h"
#include "common/util/clock.h"
#include "proto/status_envelope.h"

namespace dadrl {

// A thread of its own, from construction to destruction.
class StatusReporter {
 public:
  struct Source {
    // Fills the metrics of a status. Called on the reporter's thread.
    std::function<void(ProcessStatus&)> fill;
    // Whom the process waits for ("the replay at 127.0.0.1:7410"); empty when for nobody. Logged by
    // WaitNotice.
    std::function<std::string()> waiting_for;
    // Called on the reporter's thread several times a second; may be empty.
    std::function<void()> on_look = {};
  };

  // Borrows `publisher` and `clock`.
  StatusReporter(TelemetryPublisher& publisher, const TelemetryConfig& telemetry,
                 const StatusEnvelope& envelope, const Clock& clock, Source source);
  // Publishes a last status.
  ~StatusReporter() = default;

 private:
  void Look();
  void PublishStatus();

  TelemetryPublisher& publisher_;
  const Duration status_interval_;
  const StatusEnvelope envelope_;
  const Clock& clock_;
  const Source source_;

  // The thread's.
  TimePoint next_status_;
  WaitNotice wait_notice_;

  BackgroundThread thread_;
};

}  // namespace dadrl
