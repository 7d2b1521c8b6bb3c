#include "common/telemetry/lcm_message.h"

#include <gtest/gtest.h>

#include <string>

namespace dadrl {
namespace {

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string Text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(LcmMessage, IsWhatLcmWrites) {
  const std::string body = "body";
  const auto datagram = EncodeLcmMessage({.sequence = 0x01020304, .channel = "NAME", .packet = Bytes(body)});
  EXPECT_EQ(Text(datagram.value()), std::string("LC02\1\2\3\4NAME\0body", 17));
}

TEST(LcmMessage, ComesBackAsItWasSent) {
  for (const size_t size : {size_t{0}, size_t{1}, kMaxLcmPacket}) {
    const std::string body(size, 'x');
    const auto datagram = EncodeLcmMessage({.sequence = 0xfffffffe, .channel = "A", .packet = Bytes(body)});
    const auto message = ParseLcmMessage(datagram.value()).value();
    EXPECT_EQ(message.sequence, 0xfffffffe);
    EXPECT_EQ(message.channel, "A");
    EXPECT_EQ(Text(message.packet), body);
  }
}

TEST(LcmMessage, IsNotMadeTooLong) {
  const std::string body(kMaxLcmPacket + 1, 'x');
  EXPECT_EQ(EncodeLcmMessage({.channel = "A", .packet = Bytes(body)}).error().code,
            ErrorCode::kInvalidArgument);
  const std::string name(kMaxLcmChannel + 1, 'x');
  EXPECT_EQ(EncodeLcmMessage({.channel = name, .packet = {}}).error().code, ErrorCode::kInvalidArgument);
}

TEST(LcmMessage, RefusesEveryFragment) {
  for (const size_t size : {size_t{0}, size_t{16}, size_t{1000}}) {
    const std::string fragment = "LC03" + std::string(4 + size, '\xff');
    EXPECT_EQ(ParseLcmMessage(Bytes(fragment)).error(), LcmRefusal::kFragment);
  }
}

TEST(LcmMessage, RefusesWhatIsNone) {
  const std::string header("LC02\0\0\0\1", 8);
  const std::string longest(kMaxLcmChannel, 'x');
  EXPECT_TRUE(ParseLcmMessage(Bytes(header + longest + '\0')));
  for (const std::string& datagram : {std::string(), std::string("LC02"), header, header + "name without end",
                                      header + longest + "x" + '\0', header + std::string(60000, 'x'),
                                      std::string(1000, '\xff'), "LC01" + header.substr(4) + "A" + '\0'}) {
    EXPECT_EQ(ParseLcmMessage(Bytes(datagram)).error(), LcmRefusal::kMalformed);
  }
}

}  // namespace
}  // namespace dadrl
