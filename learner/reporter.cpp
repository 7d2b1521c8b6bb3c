#include "learner/reporter.h"

#include <cmath>

#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr Duration kPrintInterval = std::chrono::seconds(30);

// Those that the interval has.
std::vector<NamedScalar> NamedScalars(std::span<const ScalarSpec> specs, const TrainingInterval& interval) {
  std::vector<NamedScalar> named;
  for (size_t i = 0; i < specs.size(); ++i) {
    if (!std::isnan(interval.scalars[i])) named.push_back({std::string(specs[i].name), interval.scalars[i]});
  }
  return named;
}

}  // namespace

Reporter::Reporter(const TelemetryConfig& config, const Parts& parts, uint64_t incarnation)
    : interval_(FromSeconds(config.interval_s)),
      parts_(parts),
      envelope_({dds::Role::kLearner, 0, incarnation}, parts.clock, parts.trainer.ledger(),
                parts.clock.Now()),
      reported_at_(parts.clock.Now()),
      printed_at_(reported_at_),
      thread_([this](bool last) { return ReportIfDue(last); }) {}

Duration Reporter::ReportIfDue(bool last) {
  if (last || parts_.clock.Now() >= reported_at_ + interval_) Report();
  return reported_at_ + interval_ - parts_.clock.Now();
}

void Reporter::Report() {
  const TimePoint now = parts_.clock.Now();
  const TrainingInterval interval = parts_.trainer.TakeInterval();
  const FetchStats fetched = parts_.fetch_stats();
  const ProcessStatus status = MakeStatus(interval, fetched);
  const ActivityTotals& activity = status.activities;
  parts_.telemetry.Publish(status);

  const double all_s = activity.AllSeconds() - activity_.AllSeconds();
  const double work_s = activity[Activity::kWork].seconds - activity_[Activity::kWork].seconds;
  const LogContext context{.wall_time_s = 1e-9 * parts_.clock.WallTimeNs(),
                           .interval_s = ToSeconds(now - reported_at_),
                           .batch_bytes = static_cast<double>(fetched.bytes - batch_bytes_),
                           .replay_frames = static_cast<double>(fetched.frames_held),
                           .work_fraction = all_s > 0.0 ? work_s / all_s : 0.0};
  parts_.log.Add(interval, context);
  if (now - printed_at_ >= kPrintInterval) {
    spdlog::info("{} updates, {:.1f}/s, weights version {}, {:.0f} % busy; {}", interval.updates,
                 interval.interval_updates / context.interval_s, interval.weights_version,
                 100.0 * context.work_fraction, ScalarsText(status.scalars));
    printed_at_ = now;
  }
  reported_at_ = now;
  activity_ = activity;
  batch_bytes_ = fetched.bytes;
}

ProcessStatus Reporter::MakeStatus(const TrainingInterval& interval, const FetchStats& fetched) const {
  const std::optional<TimePoint> saved_at = parts_.checkpoints.saved_at();
  ProcessStatus status = envelope_.Begin();
  status[Metric::kUpdates] = interval.updates;
  status[Metric::kLearnerCpuS] = interval.cpu_s;
  status[Metric::kWeightsVersion] = interval.weights_version;
  status[Metric::kBatchBytes] = fetched.bytes;
  status[Metric::kCorruptBatches] = fetched.corrupt;
  status[Metric::kStalenessVersionsMean] = interval.staleness.versions_mean;
  status[Metric::kStalenessVersionsMax] = interval.staleness.versions_max;
  status[Metric::kStalenessSecondsMean] = interval.staleness.seconds_mean;
  status[Metric::kStalenessSecondsMax] = interval.staleness.seconds_max;
  status[Metric::kCheckpointAgeS] = saved_at ? ToSeconds(parts_.clock.Now() - *saved_at) : status.uptime_s;
  status.scalars = NamedScalars(parts_.trainer.scalar_specs(), interval);
  return status;
}

}  // namespace dadrl
