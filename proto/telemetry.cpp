#include "proto/telemetry.h"

#include <algorithm>
#include <atomic>

#include "common/telemetry/lcm_bus.h"
#include "common/util/log.h"
#include "proto/telemetry_packet.h"

namespace dadrl {
namespace {

constexpr const char* kStatusChannel = "DADRL_STATUS";
constexpr const char* kEpisodeChannel = "DADRL_EPISODE";
// Packets kept between two polls; LCM's own 30 lose a burst of a few dozen actors.
constexpr int kQueue = 4096;
// Between Cyclone's multicast ports (unused) and its unicast ports in the cluster's block.
constexpr int kTelemetryPortOffset = 5;

constexpr std::string_view kMetricNames[] = {
    "env_steps",
    "decisions",
    "episodes",
    "successes",
    "collisions",
    "off_roads",
    "stagnations",
    "simulator_failures",
    "backlog_bytes",
    "policy_version",
    "policy_age_s",
    "inserted_frames",
    "inserted_bytes",
    "sampled_transitions",
    "sampled_bytes",
    "rejected_chunks",
    "duplicate_chunks",
    "frames_held",
    "memory_bytes",
    "disk_bytes",
    "updates",
    "weights_version",
    "batch_bytes",
    "staleness_versions_mean",
    "staleness_versions_max",
    "staleness_seconds_mean",
    "staleness_seconds_max",
    "critic_loss",
    "actor_loss",
    "temperature",
    "entropy",
    "mean_q",
    "checkpoint_age_s",
};
static_assert(std::size(kMetricNames) == static_cast<size_t>(Metric::kCount));

}  // namespace

std::string_view MetricName(Metric metric) { return kMetricNames[static_cast<size_t>(metric)]; }

std::string TelemetryUrl(const ClusterConfig& cluster) {
  return fmt::format("udpm://239.255.76.67:{}?ttl=0&recv_buf_size=1048576",
                     cluster.port + kTelemetryPortOffset);
}

struct TelemetryPublisher::Impl {
  std::unique_ptr<LcmBus> bus;
  std::atomic<bool> complained{false};

  void Publish(const char* channel, const std::vector<std::byte>& packet) {
    const Status sent = bus->Publish(channel, packet);
    if (!sent && !complained.exchange(true)) spdlog::warn("telemetry: {}", sent.error().message);
  }
};

TelemetryPublisher::TelemetryPublisher(const std::string& url) {
  if (url.empty()) return;
  auto bus = LcmBus::Open(url);
  if (!bus) {
    spdlog::warn("running without telemetry: {}", bus.error().message);
    return;
  }
  impl_ = std::make_unique<Impl>();
  impl_->bus = std::move(*bus);
}

TelemetryPublisher::~TelemetryPublisher() = default;

void TelemetryPublisher::Publish(const ProcessStatus& status) {
  if (impl_) impl_->Publish(kStatusChannel, EncodePacket(status));
}

void TelemetryPublisher::Publish(const EpisodeReport& report) {
  if (impl_) impl_->Publish(kEpisodeChannel, EncodePacket(report));
}

struct TelemetrySubscriber::Impl {
  std::unique_ptr<LcmBus> bus;
  uint64_t rejected = 0;
  // Of the Poll under way.
  const std::function<void(const ProcessStatus&)>* on_status = nullptr;
  const std::function<void(const EpisodeReport&)>* on_episode = nullptr;

  // Hands a packet on when it is what it claims to be.
  template <typename Report>
  void Accept(const Result<Report>& report, const std::function<void(const Report&)>* handler) {
    if (!report) {
      if (++rejected == 1) spdlog::warn("telemetry: dropped a packet: {}", report.error().message);
      return;
    }
    if (*handler) (*handler)(*report);
  }
};

Result<std::unique_ptr<TelemetrySubscriber>> TelemetrySubscriber::Create(const std::string& url) {
  std::unique_ptr<TelemetrySubscriber> subscriber(new TelemetrySubscriber);
  subscriber->impl_ = std::make_unique<Impl>();
  Impl* const impl = subscriber->impl_.get();
  DADRL_ASSIGN_OR_RETURN(impl->bus, LcmBus::Open(url));
  DADRL_RETURN_IF_ERROR(
      impl->bus->Subscribe(kStatusChannel, kQueue, [impl](std::span<const std::byte> packet) {
        impl->Accept(DecodeStatusPacket(packet), impl->on_status);
      }));
  DADRL_RETURN_IF_ERROR(
      impl->bus->Subscribe(kEpisodeChannel, kQueue, [impl](std::span<const std::byte> packet) {
        impl->Accept(DecodeEpisodePacket(packet), impl->on_episode);
      }));
  return subscriber;
}

TelemetrySubscriber::~TelemetrySubscriber() = default;

void TelemetrySubscriber::Poll(Duration timeout, const std::function<void(const ProcessStatus&)>& on_status,
                               const std::function<void(const EpisodeReport&)>& on_episode) {
  impl_->on_status = &on_status;
  impl_->on_episode = &on_episode;
  const TimePoint deadline = std::chrono::steady_clock::now() + timeout;
  // Bounded also when packets come faster than they are handled.
  for (int left = kQueue; left > 0; --left) {
    const Duration wait = deadline - std::chrono::steady_clock::now();
    if (!impl_->bus->Handle(wait) && wait <= Duration::zero()) break;
  }
}

uint64_t TelemetrySubscriber::rejected_packets() const { return impl_->rejected; }

}  // namespace dadrl
