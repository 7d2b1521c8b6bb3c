#include "common/telemetry/lcm_bus.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

std::vector<std::byte> Packet(size_t size, std::byte fill) { return std::vector<std::byte>(size, fill); }

TEST(LcmBus, CallsTheHandlerOfTheChannelWithTheBytes) {
  const auto bus = LcmBus::Open("memq://").value();
  std::vector<std::byte> one;
  int other = 0;
  ASSERT_TRUE(bus->Subscribe(
      "ONE", 4, [&](std::span<const std::byte> packet) { one.assign(packet.begin(), packet.end()); }));
  ASSERT_TRUE(bus->Subscribe("OTHER", 4, [&](std::span<const std::byte>) { ++other; }));
  ASSERT_TRUE(bus->Publish("ONE", Packet(1000, std::byte{7})));
  EXPECT_TRUE(bus->Handle(std::chrono::seconds(10)));
  EXPECT_EQ(one, Packet(1000, std::byte{7}));
  EXPECT_EQ(other, 0);
}

TEST(LcmBus, ReturnsWithoutAPacket) {
  const auto bus = LcmBus::Open("memq://").value();
  ASSERT_TRUE(bus->Subscribe("ONE", 4, [](std::span<const std::byte>) {}));
  EXPECT_FALSE(bus->Handle(Duration::zero()));
  EXPECT_FALSE(bus->Handle(std::chrono::milliseconds(-5)));
}

TEST(LcmBus, NamesAnUnusableUrl) {
  const auto bus = LcmBus::Open("udpm://not-an-address:1");
  ASSERT_FALSE(bus);
  EXPECT_EQ(bus.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(bus.error().message.find("not-an-address"), std::string::npos);
}

}  // namespace
}  // namespace dadrl
