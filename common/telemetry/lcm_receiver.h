// Receives LCM's short messages of this host. Not liblcm's receiver: that one puts fragments together before
// anyone can look at them, and a forged pair writes outside its buffer.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "common/io/file_descriptor.h"
#include "common/telemetry/lcm_message.h"
#include "common/util/clock.h"
#include "common/util/enum_array.h"
#include "common/util/result.h"

namespace dadrl {

// Datagrams that were not taken, by LcmRefusal.
using LcmRefusals = EnumArray<LcmRefusal, uint64_t>;

// Not thread safe.
class LcmReceiver {
 public:
  // Gets a message of this host, lent for the call; what is in its packet is the handler's to check. False
  // when nobody listens to its channel.
  using Handler = std::function<bool(const LcmMessage&)>;

  // `url`: "udpm://239.255.76.67:PORT". kUnavailable when this host does not hear its own multicast (found
  // out here, in a quarter of a second).
  static Result<std::unique_ptr<LcmReceiver>> Open(const std::string& url);

  // Waits at most `timeout` for one datagram and calls `handler` when it is a message. False when none came.
  bool Receive(Duration timeout, const Handler& handler);
  // The first of each kind is logged.
  const LcmRefusals& refusals() const { return refusals_; }

 private:
  explicit LcmReceiver(FileDescriptor socket);
  void Refuse(LcmRefusal refusal);

  FileDescriptor socket_;
  std::vector<std::byte> buffer_;
  LcmRefusals refusals_{};
};

}  // namespace dadrl
