// What an actor tells the world beside its loop: a heartbeat, its status, and whom it waits for.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "actor/collect/wait_notice.h"
#include "common/dds/endpoint.h"
#include "common/util/mutex.h"
#include "proto/telemetry.h"
#include "proto/topics.h"

namespace dadrl {

// A thread of its own, from construction to destruction. The heartbeat stops when the loop has not moved for
// kHangLimit, so that liveliness proves work and not only a process.
class StatusReporter {
 public:
  struct Source {
    // Fills metrics and activity of a status; the reporter adds the rest. Called on the reporter's thread.
    std::function<void(ProcessStatus&)> fill;
    // A counter that moves whenever the loop does.
    std::function<uint64_t()> ticks;
    // Whom the process waits for ("the replay at 127.0.0.1:7410"); empty when for nobody. Logged by
    // WaitNotice.
    std::function<std::string()> waiting_for;
    // Called on the reporter's thread with every beat; may be empty.
    std::function<void()> on_beat = {};
  };

  // Loading and warming up a simulation counts as one move.
  static constexpr Duration kHangLimit = std::chrono::seconds(60);

  // Borrows `node` and `publisher`.
  static Result<std::unique_ptr<StatusReporter>> Start(const dds::Node& node, TelemetryPublisher& publisher,
                                                       const TelemetryConfig& telemetry, int actor,
                                                       uint64_t incarnation, Source source);
  ~StatusReporter();

 private:
  StatusReporter(TelemetryPublisher& publisher, Duration status_interval, Duration beat_interval, int actor,
                 uint64_t incarnation, Source source);
  void Run();
  bool WaitForStop(Duration timeout);
  void Beat(TimePoint now);
  void PublishStatus(TimePoint now);

  TelemetryPublisher& publisher_;
  const Duration status_interval_;
  const Duration beat_interval_;
  const int actor_;
  const uint64_t incarnation_;
  const Source source_;
  std::unique_ptr<dds::Writer<dadrl_idl_Heartbeat>> heartbeat_;

  // Reporter thread.
  TimePoint started_;
  TimePoint next_status_;
  TimePoint moved_;
  WaitNotice wait_notice_;
  uint64_t last_ticks_ = 0;
  uint64_t beats_ = 0;
  bool hung_ = false;

  Mutex mutex_;
  CondVar changed_;
  bool stopping_ DADRL_GUARDED_BY(mutex_) = false;
  std::thread thread_;
};

}  // namespace dadrl
