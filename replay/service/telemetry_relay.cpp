#include "replay/service/telemetry_relay.h"

#include <span>
#include <tuple>
#include <utility>

#include "common/util/log.h"
#include "proto/telemetry.h"
#include "proto/telemetry_packet.h"

namespace dadrl {

Result<std::unique_ptr<TelemetryRelay>> TelemetryRelay::Create(const Transport& transport,
                                                               const ClusterConfig& cluster) {
  std::unique_ptr<TelemetryRelay> relay(new TelemetryRelay);
  DADRL_ASSIGN_OR_RETURN(relay->out_, Writer<dadrl_idl_Telemetry>::Create(transport, kRelayedTelemetryTopic));
  DADRL_ASSIGN_OR_RETURN(relay->in_, Reader<dadrl_idl_Telemetry>::Create(transport, kTelemetryTopic));
  if (auto lcm = LcmSender::Open(TelemetryUrl(cluster))) relay->lcm_ = std::move(*lcm);
  return relay;
}

void TelemetryRelay::Pass() {
  in_->Take(kTelemetryDepth, [this](const dadrl_idl_Telemetry& message) { OnPacket(message); });
}

void TelemetryRelay::OnPacket(const dadrl_idl_Telemetry& message) {
  const std::span<const std::byte> packet(reinterpret_cast<const std::byte*>(message.packet._buffer),
                                          message.packet._length);
  const bool sound =
      message.is_episode ? DecodeEpisodePacket(packet).has_value() : DecodeStatusPacket(packet).has_value();
  if (!sound) {
    if (++rejected_ == 1) spdlog::warn("telemetry from another machine: dropped a malformed packet");
    return;
  }
  // Lossy on purpose: what does not leave now is out of date soon.
  if (lcm_) std::ignore = lcm_->Publish(TelemetryChannel(message.is_episode), packet);
  std::ignore = out_->Write(message);
}

}  // namespace dadrl
