// Brings telemetry to where LCM does not reach: processes on other machines or hosts without multicast write
// it to the control domain; shard 0 passes it on, to LCM on its host and to monitors that read DDS.
#pragma once

#include <cstdint>
#include <memory>

#include "common/config/config.h"
#include "common/port/port.h"
#include "common/telemetry/lcm_sender.h"
#include "common/util/result.h"
#include "proto/topics.h"

namespace dadrl {

// Not thread safe; never blocks. Packets that are not what they claim to be are dropped and counted.
class TelemetryRelay {
 public:
  static Result<std::unique_ptr<TelemetryRelay>> Create(const Transport& transport,
                                                        const ClusterConfig& cluster);
  // Passes on what has arrived.
  void Pass();

 private:
  TelemetryRelay() = default;
  void OnPacket(const dadrl_idl_Telemetry& message);

  std::unique_ptr<Reader<dadrl_idl_Telemetry>> in_;
  std::unique_ptr<Writer<dadrl_idl_Telemetry>> out_;
  std::unique_ptr<LcmSender> lcm_;  // null where the host does not hear its own multicast
  uint64_t rejected_ = 0;
};

}  // namespace dadrl
