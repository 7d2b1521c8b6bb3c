#include "actor/collect/status_reporter.h"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "common/util/log.h"

namespace dadrl {
namespace {

TimePoint Now() { return SystemClock().Now(); }

}  // namespace

Result<std::unique_ptr<StatusReporter>> StatusReporter::Start(const dds::Node& node,
                                                              TelemetryPublisher& publisher,
                                                              const TelemetryConfig& telemetry, int actor,
                                                              uint64_t incarnation, Source source) {
  std::unique_ptr<StatusReporter> reporter(new StatusReporter(publisher, FromSeconds(telemetry.interval_s),
                                                              FromSeconds(node.liveliness_s() / 4), actor,
                                                              incarnation, std::move(source)));
  DADRL_ASSIGN_OR_RETURN(reporter->heartbeat_,
                         dds::Writer<dadrl_idl_Heartbeat>::Create(node, kHeartbeatTopic));
  reporter->thread_ = std::thread([raw = reporter.get()] { raw->Run(); });
  return reporter;
}

StatusReporter::StatusReporter(TelemetryPublisher& publisher, Duration status_interval,
                               Duration beat_interval, int actor, uint64_t incarnation, Source source)
    : publisher_(publisher),
      status_interval_(status_interval),
      beat_interval_(beat_interval),
      actor_(actor),
      incarnation_(incarnation),
      source_(std::move(source)),
      started_(Now()),
      next_status_(started_),
      moved_(started_) {}

StatusReporter::~StatusReporter() {
  if (!thread_.joinable()) return;
  {
    MutexLock lock(mutex_);
    stopping_ = true;
    changed_.NotifyAll();
  }
  thread_.join();
  PublishStatus(Now());
}

void StatusReporter::Run() {
  do {
    const TimePoint now = Now();
    Beat(now);
    if (source_.on_beat) source_.on_beat();
    wait_notice_.Update(source_.waiting_for(), now);
    if (now >= next_status_) PublishStatus(now);
  } while (!WaitForStop(std::min(beat_interval_, status_interval_)));
}

bool StatusReporter::WaitForStop(Duration timeout) {
  MutexLock lock(mutex_);
  if (!stopping_) changed_.WaitFor(mutex_, timeout);
  return stopping_;
}

void StatusReporter::Beat(TimePoint now) {
  const uint64_t ticks = source_.ticks();
  if (ticks != last_ticks_) {
    last_ticks_ = ticks;
    moved_ = now;
  }
  const bool hung = now - moved_ > kHangLimit;
  if (hung && !hung_) spdlog::error("the simulation has not moved for {:.0f} s", ToSeconds(now - moved_));
  hung_ = hung;
  if (hung) return;
  dadrl_idl_Heartbeat beat{};
  beat.role = static_cast<uint32_t>(dds::Role::kActor);
  beat.index = static_cast<uint32_t>(actor_);
  beat.incarnation = incarnation_;
  beat.beat = ++beats_;
  // A beat that is not sent is one that is missed; nobody is there to hear more about it.
  static_cast<void>(heartbeat_->Write(beat));
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
  source_.fill(status);
  publisher_.Publish(status);
}

}  // namespace dadrl
