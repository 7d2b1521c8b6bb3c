// Raw packets over LCM, RAII: the generic half of telemetry. What is in a packet is the caller's to check:
// anyone on this host can send one, and the decoders that lcm-gen writes trust their input.
#pragma once

#include <lcm/lcm.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/util/clock.h"
#include "common/util/result.h"

namespace dadrl {

// Publish may be called by any thread; Subscribe and Handle by one.
class LcmBus {
 public:
  // Gets the packet's bytes, lent for the call.
  using Handler = std::function<void(std::span<const std::byte>)>;

  // `url`: "udpm://239.255.76.67:PORT?ttl=0", "memq://" (this object only). kUnavailable when the host does
  // not hear its own multicast (found out here, in a quarter of a second).
  static Result<std::unique_ptr<LcmBus>> Open(const std::string& url);
  ~LcmBus();
  LcmBus(const LcmBus&) = delete;
  LcmBus& operator=(const LcmBus&) = delete;

  // Never blocks; a packet may be lost without a word. kUnavailable when the system refused it.
  Status Publish(const std::string& channel, std::span<const std::byte> packet);

  // Queues up to `queue` packets of `channel` between two calls of Handle, then drops. kUnavailable when LCM
  // itself hears nothing of its own.
  Status Subscribe(const std::string& channel, int queue, Handler handler);

  // Waits at most `timeout` for one packet and calls its handler on this thread. False when none came.
  bool Handle(Duration timeout);

 private:
  explicit LcmBus(lcm_t* lcm) : lcm_(lcm) {}

  lcm_t* lcm_;
  std::vector<std::unique_ptr<Handler>> handlers_;  // LCM holds their addresses
};

}  // namespace dadrl
