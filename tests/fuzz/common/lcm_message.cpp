// A datagram that anyone on this host sends to the telemetry's group.
#include "common/telemetry/lcm_message.h"

#include <algorithm>
#include <string>

#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

Bytes Input(const std::string& datagram) {
  const auto bytes = std::as_bytes(std::span(datagram));
  return {bytes.begin(), bytes.end()};
}

bool IsInside(const void* begin, size_t size, std::span<const std::byte> input) {
  const auto* first = static_cast<const std::byte*>(begin);
  return first >= input.data() && first + size <= input.data() + input.size();
}

}  // namespace

const int kMutants = 300000;

bool Check(std::span<std::byte> input) {
  const auto message = ParseLcmMessage(input);
  if (!message) {
    Require(message.error() < LcmRefusal::kCount && !LcmRefusalName(message.error()).empty());
    return false;
  }
  Require(message->channel.size() <= kMaxLcmChannel && message->channel.find('\0') == std::string_view::npos);
  Require(IsInside(message->channel.data(), message->channel.size() + 1, input));
  Require(IsInside(message->packet.data(), message->packet.size(), input));
  if (message->packet.size() > kMaxLcmPacket) return true;  // one that we would not send
  Require(std::ranges::equal(EncodeLcmMessage(*message).value(), input));
  return true;
}

Seeds MakeSeeds() {
  const std::string header("LC02\0\0\0\1", 8);
  Seeds seeds;
  for (const std::string& datagram : {header + "DADRL_STATUS" + '\0' + std::string(820, 'x'), header + '\0',
                                      header + std::string(63, 'n') + '\0'}) {
    seeds.accepted.push_back(Input(datagram));
  }
  // The pair that writes outside the buffer of LCM's own receiver, and what is no message.
  const std::string first("LC03\0\0\0\7\0\0\3\xe8\0\0\0\0\0\0\0\3", 20);
  const std::string second("LC03\0\0\0\7\0\0\3\xe8\xff\xff\xff\0\0\1\0\3", 20);
  for (const std::string& datagram : {first + "DADRL_STATUS" + '\0' + "A", second + std::string(512, 'B'),
                                      std::string(), header, header + std::string(64, 'n') + '\0'}) {
    seeds.refused.push_back(Input(datagram));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
