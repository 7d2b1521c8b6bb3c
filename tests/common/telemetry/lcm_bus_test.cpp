#include "common/telemetry/lcm_bus.h"

#include <gmock/gmock.h>
#include <sched.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>

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

// In a host of its own whose kernel lets nobody join a group: LCM itself would open there.
int OpenWhereNobodyHears(const std::string& url) {
  const pid_t child = fork();
  if (child == 0) {
    if (unshare(CLONE_NEWNET) != 0) _exit(2);
    if (std::system("ip link set lo up && ip route add 224.0.0.0/4 dev lo") != 0) _exit(3);
    if (!LcmBus::Open(url)) _exit(4);
    std::ofstream("/proc/sys/net/ipv4/igmp_max_memberships") << 0;
    const auto bus = LcmBus::Open(url);
    const bool said = !bus && bus.error().code == ErrorCode::kUnavailable &&
                      bus.error().message.find("does not hear its own multicast") != std::string::npos;
    _exit(said ? 0 : 5);
  }
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(LcmBus, SaysThatTheHostDoesNotHearItselfInsteadOfSpeakingToNobody) {
  if (geteuid() != 0) GTEST_SKIP() << "only root may make a network namespace";
  EXPECT_EQ(OpenWhereNobodyHears("udpm://239.255.76.67:7667?ttl=0"), 0);
}

}  // namespace
}  // namespace dadrl
