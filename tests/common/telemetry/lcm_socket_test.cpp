// Real datagrams on this host.
#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>

#include "common/telemetry/lcm_receiver.h"
#include "common/telemetry/lcm_sender.h"
#include "common/telemetry/multicast.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/common/network_namespace.h"
#include "tests/common/util/eventually.h"

namespace dadrl {
namespace {

constexpr Duration kMoment = std::chrono::milliseconds(200);
constexpr const char* kGroup = "239.255.76.67";

std::span<const std::byte> Bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

// A port of this process's own.
int Port() { return 42000 + getpid() % 1000; }
std::string Url() { return fmt::format("udpm://{}:{}?ttl=0", kGroup, Port()); }

sockaddr_in To(const char* address) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = inet_addr(address);
  to.sin_port = htons(static_cast<uint16_t>(Port()));
  return to;
}

// As anybody would: by the interface of the route, or by loopback.
void Send(const char* address, const std::string& datagram, bool by_loopback) {
  const FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const in_addr loopback{htonl(INADDR_LOOPBACK)};
  if (by_loopback) setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback));
  const sockaddr_in to = To(address);
  EXPECT_EQ(sendto(socket.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                   sizeof(to)),
            static_cast<ssize_t>(datagram.size()));
}

std::string ShortMessage(const std::string& channel, const std::string& body) {
  return std::string("LC02\0\0\0\1", 8) + channel + '\0' + body;
}

// What the receiver of a careless program hears: bound to any address, joined where the route leads.
FileDescriptor CarelessReceiver() {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int yes = 1;
  setsockopt(socket.get(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof(yes));
  const sockaddr_in any = To("0.0.0.0");
  EXPECT_EQ(bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof(any)), 0);
  const ip_mreq membership{.imr_multiaddr = To(kGroup).sin_addr, .imr_interface = {INADDR_ANY}};
  EXPECT_EQ(setsockopt(socket.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)), 0);
  const timeval limit{.tv_sec = 10, .tv_usec = 0};
  setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof(limit));
  return socket;
}

std::string Heard(const FileDescriptor& socket) {
  std::string text(1000, '\0');
  const ssize_t size = recv(socket.get(), text.data(), text.size(), 0);
  text.resize(static_cast<size_t>(std::max<ssize_t>(size, 0)));
  return text;
}

// The next message, with the channel that it came by.
std::optional<std::string> Next(LcmReceiver& receiver, Duration timeout = std::chrono::seconds(10)) {
  std::optional<std::string> heard;
  receiver.Receive(timeout, [&](const LcmMessage& message) {
    if (message.channel != "A") return false;
    heard = std::string(reinterpret_cast<const char*>(message.packet.data()), message.packet.size());
    return true;
  });
  return heard;
}

TEST(LcmSocket, CarriesPacketsToEverybodyOnThisHostWhoListens) {
  const auto first = LcmReceiver::Open(Url()).value();
  const auto second = LcmReceiver::Open(Url()).value();
  const auto sender = LcmSender::Open(Url()).value();
  ASSERT_TRUE(sender->Publish("A", Bytes("word")));
  EXPECT_EQ(Next(*first), "word");
  EXPECT_EQ(Next(*second), "word");
  EXPECT_FALSE(Next(*first, Duration::zero()));
  EXPECT_EQ(first->refusals(), LcmRefusals{});
}

TEST(LcmSocket, RefusesFragmentsAndCountsThem) {
  const auto receiver = LcmReceiver::Open(Url()).value();
  // The pair that writes outside the buffer of LCM's own receiver.
  const std::string first("LC03\0\0\0\7\0\0\3\xe8\0\0\0\0\0\0\0\3", 20);
  const std::string second("LC03\0\0\0\7\0\0\3\xe8\xff\xff\xff\0\0\1\0\3", 20);
  Send(kGroup, first + "A" + '\0' + std::string(100, 'A'), true);
  Send(kGroup, second + std::string(512, 'B'), true);
  Send(kGroup, ShortMessage("B", "nobody listens"), true);
  Send(kGroup, "LC", true);
  Send(kGroup, ShortMessage("A", "sound"), true);
  for (int i = 0; i < 4; ++i) EXPECT_FALSE(Next(*receiver));
  EXPECT_EQ(Next(*receiver), "sound");
  EXPECT_EQ(receiver->refusals(), (LcmRefusals{0, 2, 1, 1}));
}

TEST(LcmSocket, HearsNothingThatIsSentToAnAddressOfThisHost) {
  const auto receiver = LcmReceiver::Open(Url()).value();
  Send("127.0.0.1", ShortMessage("A", "forged"), true);
  EXPECT_FALSE(Next(*receiver, kMoment));
  EXPECT_EQ(receiver->refusals(), LcmRefusals{});
}

TEST(LcmSocket, NamesAUrlThatIsNoGroup) {
  for (const char* url : {"udpm://not-an-address:1", "udpm://300.0.0.1:1", "udpm://10.0.0.1:7667", "memq://",
                          "udpm://239.255.76.67", "udpm://239.255.76.67:70000", "udpm://239.255.76.67:1x"}) {
    const auto receiver = LcmReceiver::Open(url);
    ASSERT_FALSE(receiver) << url;
    EXPECT_THAT(receiver.error().message, testing::HasSubstr(url));
    EXPECT_FALSE(LcmSender::Open(url));
  }
}

TEST(LcmSocket, NothingThatAnotherMachineSendsArrivesNorDoesAnotherMachineHearAnything) {
  if (!MayMakeNamespaces()) GTEST_SKIP() << "only root may make network namespaces";
  const NetworkNamespace here('a');
  const NetworkNamespace there('b');
  Connect(here, "10.213.78.1", there, "10.213.78.2");
  for (const auto* machine : {&here, &there}) {
    Ip(fmt::format("-n {} route add 224.0.0.0/4 dev {}", machine->name(), machine->device()));
  }
  std::unique_ptr<LcmReceiver> receiver;
  std::unique_ptr<LcmSender> sender;
  FileDescriptor careless_here;
  FileDescriptor careless_there;
  here.Run([&] {
    receiver = LcmReceiver::Open(Url()).value();
    sender = LcmSender::Open(Url()).value();
    careless_here = CarelessReceiver();
  });
  there.Run([&] {
    careless_there = CarelessReceiver();
    Send(kGroup, ShortMessage("A", "forged"), false);
    Send("10.213.78.1", ShortMessage("A", "forged"), false);
  });
  // Both were on the cable and have come in.
  for (int i = 0; i < 2; ++i) EXPECT_THAT(Heard(careless_here), testing::HasSubstr("forged"));
  EXPECT_FALSE(Next(*receiver, kMoment));
  EXPECT_EQ(receiver->refusals(), LcmRefusals{});

  EXPECT_THAT(Heard(careless_there), testing::HasSubstr("forged")) << "its own";
  ASSERT_TRUE(sender->Publish("A", Bytes("secret")));
  EXPECT_EQ(Next(*receiver), "secret");
  there.Run([&] { Send(kGroup, "last", false); });
  EXPECT_EQ(Heard(careless_there), "last") << "what it would have heard before";
}

TEST(LcmSocket, SaysThatTheHostDoesNotHearItselfInsteadOfSpeakingToNobody) {
  if (!MayMakeNamespaces()) GTEST_SKIP() << "only root may make network namespaces";
  const NetworkNamespace host('c');
  host.Run([&] { ASSERT_TRUE(LcmSender::Open(Url())); });
  Ip(fmt::format("netns exec {} sysctl -qw net.ipv4.igmp_max_memberships=0", host.name()));
  host.Run([&] {
    for (const Error& error : {LcmSender::Open(Url()).error(), LcmReceiver::Open(Url()).error()}) {
      EXPECT_EQ(error.code, ErrorCode::kUnavailable);
      EXPECT_THAT(error.message, testing::HasSubstr("does not hear its own multicast"));
    }
  });
}

// LCM's own tools are who reads telemetry besides the monitor.
TEST(LcmSocket, LcmLoggerRecordsWhatIsSent) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "log";
  const std::string url = "--lcm-url=" + Url();
  std::vector<std::string> words = {"lcm-logger", "-q", "--flush-interval=1", url, file};
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  pid_t logger = 0;
  ASSERT_EQ(posix_spawnp(&logger, "lcm-logger", nullptr, nullptr, arguments.data(), environ), 0);
  const auto sender = LcmSender::Open(Url()).value();
  const bool recorded = Eventually([&] {
    EXPECT_TRUE(sender->Publish("DADRL_STATUS", Bytes("packet 17")));
    std::ifstream stream(file, std::ios::binary);
    const std::string log{std::istreambuf_iterator<char>(stream), {}};
    return log.find("DADRL_STATUSpacket 17") != std::string::npos;
  });
  EXPECT_TRUE(recorded);
  kill(logger, SIGTERM);
  waitpid(logger, nullptr, 0);
}

}  // namespace
}  // namespace dadrl
