// What the learner tells people, once an interval: LCM status, training log, a line now and then.
#pragma once

#include <functional>

#include "common/config/config.h"
#include "common/util/background_thread.h"
#include "common/util/clock.h"
#include "learner/batch_fetcher.h"
#include "learner/checkpoint_writer.h"
#include "learner/trainer.h"
#include "learner/training_log.h"
#include "proto/status_envelope.h"

namespace dadrl {

// Owns a thread, so that neither the disk nor a network can hold up training.
class Reporter {
 public:
  // Borrowed; they outlive the reporter.
  struct Parts {
    Trainer& trainer;
    const CheckpointWriter& checkpoints;
    TelemetryPublisher& telemetry;
    TrainingLog& log;
    std::function<FetchStats()> fetch_stats;
    const Clock& clock;
  };
  Reporter(const TelemetryConfig& config, const Parts& parts, uint64_t incarnation);
  // Reports the last, partial interval.
  ~Reporter() = default;

 private:
  Duration ReportIfDue(bool last);
  void Report();
  ProcessStatus MakeStatus(const TrainingInterval& interval, const FetchStats& fetched) const;

  const Duration interval_;
  Parts parts_;
  const StatusEnvelope envelope_;

  // The reporter's thread: what the last report said.
  TimePoint reported_at_;
  TimePoint printed_at_;
  ActivityTotals activity_;
  uint64_t batch_bytes_ = 0;

  BackgroundThread thread_;
};

}  // namespace dadrl
