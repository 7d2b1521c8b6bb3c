#include "proto/telemetry.h"

#include <algorithm>
#include <atomic>

#include "common/dds/address.h"
#include "common/port/port.h"
#include "common/telemetry/lcm_receiver.h"
#include "common/telemetry/lcm_sender.h"
#include "common/util/log.h"
#include "proto/borrowed_sequence.h"
#include "proto/telemetry_packet.h"
#include "proto/topics.h"

namespace dadrl {
namespace {

constexpr const char* kStatusChannel = "DADRL_STATUS";
constexpr const char* kEpisodeChannel = "DADRL_EPISODE";
// Handled in one poll: one that is flooded ends all the same.
constexpr int kPacketsOfAPoll = 4096;
// Between Cyclone's multicast ports (unused) and its unicast ports in the cluster's block.
constexpr int kTelemetryPortOffset = 5;

constexpr EnumArray<Metric, std::string_view> kMetricNames = {
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
    "refused_chunks",
    "inserted_frames",
    "inserted_bytes",
    "sampled_transitions",
    "sampled_bytes",
    "rejected_garbage",
    "rejected_version",
    "rejected_length",
    "rejected_checksum",
    "rejected_contents",
    "rejected_schema",
    "rejected_stale",
    "duplicate_chunks",
    "lost_chunks",
    "refused_requests",
    "refused_priorities",
    "frames_held",
    "memory_bytes",
    "disk_bytes",
    "snapshot_bytes",
    "updates",
    "weights_version",
    "batch_bytes",
    "corrupt_batches",
    "staleness_versions_mean",
    "staleness_versions_max",
    "staleness_seconds_mean",
    "staleness_seconds_max",
    "checkpoint_age_s",
    "learner_cpu_s",
};
static_assert(!kMetricNames.back().empty());

}  // namespace

std::string_view MetricName(Metric metric) { return kMetricNames[metric]; }

std::string TelemetryUrl(const ClusterConfig& cluster) {
  return fmt::format("udpm://239.255.76.67:{}?ttl=0", cluster.port + kTelemetryPortOffset);
}

const char* TelemetryChannel(bool is_episode) { return is_episode ? kEpisodeChannel : kStatusChannel; }

// One of the two ways is there.
struct TelemetryPublisher::Impl {
  std::unique_ptr<LcmSender> lcm;
  std::unique_ptr<Writer<dadrl_idl_Telemetry>> relay;
  std::atomic<bool> complained{false};

  void Publish(bool is_episode, std::span<const std::byte> packet) {
    const Status sent =
        lcm ? lcm->Publish(TelemetryChannel(is_episode), packet) : WriteToRelay(is_episode, packet);
    if (!sent && !complained.exchange(true)) spdlog::warn("telemetry: {}", sent.error().message);
  }
  Status WriteToRelay(bool is_episode, std::span<const std::byte> packet) {
    dadrl_idl_Telemetry message{};
    message.is_episode = is_episode;
    Borrow(packet, message.packet);
    return relay->Write(message);
  }
};

TelemetryPublisher::TelemetryPublisher(const std::string& url) {
  if (url.empty()) return;
  auto lcm = LcmSender::Open(url);
  if (!lcm) {
    spdlog::warn("running without telemetry: {}", lcm.error().message);
    return;
  }
  impl_ = std::make_unique<Impl>();
  impl_->lcm = std::move(*lcm);
}

TelemetryPublisher::TelemetryPublisher(const Config& config, const dds::Node& node) {
  if (!config.telemetry.enabled) return;
  impl_ = std::make_unique<Impl>();
  const Result<std::string> address = dds::ResolveHost(config.cluster.host);
  if (address && dds::IsLocalAddress(*address)) {
    if (auto lcm = LcmSender::Open(TelemetryUrl(config.cluster))) impl_->lcm = std::move(*lcm);
  }
  if (impl_->lcm) return;
  auto relay = Writer<dadrl_idl_Telemetry>::Create(node, kTelemetryTopic);
  if (!relay) {
    spdlog::warn("running without telemetry: {}", relay.error().message);
    impl_.reset();
    return;
  }
  impl_->relay = std::move(*relay);
}

TelemetryPublisher::~TelemetryPublisher() = default;

void TelemetryPublisher::Publish(const ProcessStatus& status) {
  if (impl_) impl_->Publish(false, EncodePacket(status));
}

void TelemetryPublisher::Publish(const EpisodeReport& report) {
  if (impl_) impl_->Publish(true, EncodePacket(report));
}

// One of the two ways is there.
struct TelemetrySubscriber::Impl {
  std::unique_ptr<LcmReceiver> lcm;
  std::unique_ptr<dds::Node> node;
  std::unique_ptr<Reader<dadrl_idl_Telemetry>> relayed;
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
  void OnPacket(bool is_episode, std::span<const std::byte> packet) {
    if (is_episode) {
      Accept(DecodeEpisodePacket(packet), on_episode);
    } else {
      Accept(DecodeStatusPacket(packet), on_status);
    }
  }
  bool OnMessage(const LcmMessage& message) {
    for (const bool is_episode : {false, true}) {
      if (message.channel != TelemetryChannel(is_episode)) continue;
      OnPacket(is_episode, message.packet);
      return true;
    }
    return false;
  }
  // Waits at most `timeout`; false when nothing came.
  bool Handle(Duration timeout) {
    if (lcm) return lcm->Receive(timeout, [this](const LcmMessage& message) { return OnMessage(message); });
    relayed->Wait(timeout);
    return relayed->Take(1, [this](const dadrl_idl_Telemetry& message) {
      OnPacket(message.is_episode,
               {reinterpret_cast<const std::byte*>(message.packet._buffer), message.packet._length});
    }) > 0;
  }
};

Result<std::unique_ptr<TelemetrySubscriber>> TelemetrySubscriber::Create(const std::string& url) {
  std::unique_ptr<TelemetrySubscriber> subscriber(new TelemetrySubscriber);
  subscriber->impl_ = std::make_unique<Impl>();
  DADRL_ASSIGN_OR_RETURN(subscriber->impl_->lcm, LcmReceiver::Open(url));
  return subscriber;
}

Result<std::unique_ptr<TelemetrySubscriber>> TelemetrySubscriber::CreateRelayed(const Config& config,
                                                                                const std::string& key) {
  std::unique_ptr<TelemetrySubscriber> subscriber(new TelemetrySubscriber);
  subscriber->impl_ = std::make_unique<Impl>();
  Impl* const impl = subscriber->impl_.get();
  DADRL_ASSIGN_OR_RETURN(
      impl->node, dds::Node::Create(config.cluster, config.replay.shards, dds::Role::kMonitor, 0, key));
  DADRL_ASSIGN_OR_RETURN(impl->relayed,
                         Reader<dadrl_idl_Telemetry>::Create(*impl->node, kRelayedTelemetryTopic));
  return subscriber;
}

Result<std::unique_ptr<TelemetrySubscriber>> TelemetrySubscriber::Create(const Config& config,
                                                                         const std::string& key) {
  auto subscriber = Create(TelemetryUrl(config.cluster));
  return subscriber ? std::move(subscriber) : CreateRelayed(config, key);
}

TelemetrySubscriber::~TelemetrySubscriber() = default;

void TelemetrySubscriber::Poll(Duration timeout, const std::function<void(const ProcessStatus&)>& on_status,
                               const std::function<void(const EpisodeReport&)>& on_episode) {
  impl_->on_status = &on_status;
  impl_->on_episode = &on_episode;
  const TimePoint deadline = std::chrono::steady_clock::now() + timeout;
  for (int left = kPacketsOfAPoll; left > 0; --left) {
    const Duration wait = deadline - std::chrono::steady_clock::now();
    if (!impl_->Handle(wait) && wait <= Duration::zero()) break;
  }
}

TelemetryRefusals TelemetrySubscriber::refusals() const {
  TelemetryRefusals refusals;
  if (impl_->rejected > 0) refusals["impossible contents"] = impl_->rejected;
  for (size_t i = 0; impl_->lcm && i < impl_->lcm->refusals().size(); ++i) {
    const uint64_t count = impl_->lcm->refusals()[i];
    if (count > 0) refusals[std::string(LcmRefusalName(LcmRefusals::At(i)))] = count;
  }
  return refusals;
}

}  // namespace dadrl
