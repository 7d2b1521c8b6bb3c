// LCM's short message, the one kind of datagram that telemetry uses: magic "LC02", sequence number (big
// endian), the channel's name up to a zero, the packet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "common/util/result.h"

namespace dadrl {

struct LcmMessage {
  uint32_t sequence = 0;  // of its sender
  std::string_view channel;
  std::span<const std::byte> packet;
};

// Why a datagram was not taken.
enum class LcmRefusal {
  kStranger,   // not sent on this host
  kFragment,   // part of a longer message ("LC03"): ours are one datagram each, and nothing is put together
  kMalformed,  // no LCM message
  kChannel,    // one that nobody here listens to
  kCount,
};

// "fragment", for counts and messages.
std::string_view LcmRefusalName(LcmRefusal refusal);

// Longest name of a channel, as in LCM.
constexpr size_t kMaxLcmChannel = 63;
// Longest packet of a short message.
constexpr size_t kMaxLcmPacket = 65'000;

// What is returned borrows `datagram`. Reads nothing outside it, allocates nothing.
tl::expected<LcmMessage, LcmRefusal> ParseLcmMessage(std::span<const std::byte> datagram);

// kInvalidArgument when the channel's name or the packet is too long.
Result<std::vector<std::byte>> EncodeLcmMessage(const LcmMessage& message);

}  // namespace dadrl
