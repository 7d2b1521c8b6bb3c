#include "common/telemetry/lcm_message.h"

#include <algorithm>

#include "common/util/enum_array.h"

namespace dadrl {
namespace {

constexpr uint32_t kShortMagic = 0x4c433032;     // "LC02"
constexpr uint32_t kFragmentMagic = 0x4c433033;  // "LC03"
constexpr size_t kHeader = 8;

uint32_t BigEndian(std::span<const std::byte> bytes) {
  uint32_t value = 0;
  for (const std::byte byte : bytes.first(4)) value = value << 8 | std::to_integer<uint32_t>(byte);
  return value;
}

void AppendBigEndian(uint32_t value, std::vector<std::byte>& bytes) {
  for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(std::byte(value >> shift & 0xff));
}

}  // namespace

std::string_view LcmRefusalName(LcmRefusal refusal) {
  constexpr EnumArray<LcmRefusal, std::string_view> kNames = {"from another host", "fragment", "malformed",
                                                              "unknown channel"};
  return kNames[refusal];
}

tl::expected<LcmMessage, LcmRefusal> ParseLcmMessage(std::span<const std::byte> datagram) {
  if (datagram.size() < kHeader) return tl::unexpected(LcmRefusal::kMalformed);
  const uint32_t magic = BigEndian(datagram);
  if (magic == kFragmentMagic) return tl::unexpected(LcmRefusal::kFragment);
  if (magic != kShortMagic) return tl::unexpected(LcmRefusal::kMalformed);
  const auto rest = datagram.subspan(kHeader);
  const auto end_of_names = rest.begin() + static_cast<ptrdiff_t>(std::min(rest.size(), kMaxLcmChannel + 1));
  const auto end = std::find(rest.begin(), end_of_names, std::byte{0});
  if (end == end_of_names) return tl::unexpected(LcmRefusal::kMalformed);
  const auto length = static_cast<size_t>(end - rest.begin());
  return LcmMessage{.sequence = BigEndian(datagram.subspan(4)),
                    .channel = {reinterpret_cast<const char*>(rest.data()), length},
                    .packet = rest.subspan(length + 1)};
}

Result<std::vector<std::byte>> EncodeLcmMessage(const LcmMessage& message) {
  if (message.channel.size() > kMaxLcmChannel || message.packet.size() > kMaxLcmPacket) {
    return Fail(ErrorCode::kInvalidArgument,
                "LCM message on {} of {} bytes: a channel has at most {} characters, a packet {} bytes",
                message.channel, message.packet.size(), kMaxLcmChannel, kMaxLcmPacket);
  }
  std::vector<std::byte> datagram;
  datagram.reserve(kHeader + message.channel.size() + 1 + message.packet.size());
  AppendBigEndian(kShortMagic, datagram);
  AppendBigEndian(message.sequence, datagram);
  const auto name = std::as_bytes(std::span(message.channel));
  datagram.insert(datagram.end(), name.begin(), name.end());
  datagram.push_back(std::byte{0});
  datagram.insert(datagram.end(), message.packet.begin(), message.packet.end());
  return datagram;
}

}  // namespace dadrl
