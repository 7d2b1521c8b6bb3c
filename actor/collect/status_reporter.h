// What an actor tells the world beside its loop: its status, and whom it waits for.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "actor/collect/wait_notice.h"
#include "common/util/background_thread.h"
#include "common/util/clock.h"
#include "proto/telemetry.h"

namespace dadrl {

// A thread of its own, from construction to destruction.
class StatusReporter {
 public:
  struct Source {
    // Fills metrics and activity of a status; the reporter adds the rest. Called on the reporter's thread.
    std::function<void(ProcessStatus&)> fill;
    // Whom the process waits for ("the replay at 127.0.0.1:7410"); empty when for nobody. Logged by
    // WaitNotice.
    std::function<std::string()> waiting_for;
    // Called on the reporter's thread several times a second; may be empty.
    std::function<void()> on_look = {};
  };

  // Borrows `publisher`.
  StatusReporter(TelemetryPublisher& publisher, const TelemetryConfig& telemetry, int actor,
                 uint64_t incarnation, Source source);
  // Publishes a last status.
  ~StatusReporter() = default;

 private:
  void Look(TimePoint now);
  void PublishStatus(TimePoint now);

  TelemetryPublisher& publisher_;
  const Duration status_interval_;
  const int actor_;
  const uint64_t incarnation_;
  const Source source_;

  // The thread's.
  TimePoint started_;
  TimePoint next_status_;
  WaitNotice wait_notice_;

  BackgroundThread thread_;
};

}  // namespace dadrl
