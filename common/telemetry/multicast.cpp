#include "common/telemetry/multicast.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <string>

namespace dadrl {
namespace {

// A packet may be lost, and the host may be busy.
constexpr int kAttempts = 5;
constexpr int kWait_ms = 50;
// Some hundred packets: a burst of all processes between two looks.
constexpr int kReceiveBufferBytes = 1 << 20;

tl::unexpected<Error> Failed(const char* what) {
  return Fail(ErrorCode::kUnavailable, "{}: {}", what, std::strerror(errno));
}

template <typename Value>
bool Set(const FileDescriptor& socket, int level, int option, const Value& value) {
  return setsockopt(socket.get(), level, option, &value, sizeof(value)) == 0;
}

Status Bind(const FileDescriptor& socket, const sockaddr_in& address) {
  if (bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0) return {};
  return Failed("bind");
}

// On the loopback interface, and where there is none on no other: the kernel would choose one for index 0.
ip_mreqn OnLoopback(const sockaddr_in& group) {
  const auto loopback = static_cast<int>(if_nametoindex("lo"));
  return {.imr_multiaddr = group.sin_addr,
          .imr_address = {INADDR_ANY},
          .imr_ifindex = loopback > 0 ? loopback : -1};
}

Result<FileDescriptor> UdpSocket() {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket.valid()) return Failed("socket");
  return socket;
}

}  // namespace

Result<sockaddr_in> ParseMulticastUrl(std::string_view url) {
  constexpr std::string_view kScheme = "udpm://";
  const auto refused = [url = std::string(url)] {
    return Fail(ErrorCode::kInvalidArgument, "'{}' is not udpm://GROUP:PORT with a multicast group", url);
  };
  if (!url.starts_with(kScheme)) return refused();
  const std::string_view place = url.substr(kScheme.size(), url.find('?') - kScheme.size());
  const size_t colon = place.find(':');
  if (colon == std::string_view::npos) return refused();
  sockaddr_in group{};
  group.sin_family = AF_INET;
  if (inet_pton(AF_INET, std::string(place.substr(0, colon)).c_str(), &group.sin_addr) != 1) return refused();
  if (!IN_MULTICAST(ntohl(group.sin_addr.s_addr))) return refused();
  uint16_t port = 0;
  const char* const end = place.data() + place.size();
  const auto [stop, error] = std::from_chars(place.data() + colon + 1, end, port);
  if (error != std::errc() || stop != end) return refused();
  group.sin_port = htons(port);
  return group;
}

Result<FileDescriptor> OpenMulticastReceiver(const sockaddr_in& group) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor socket, UdpSocket());
  Set(socket, SOL_SOCKET, SO_RCVBUF, kReceiveBufferBytes);  // the host may grant less
  if (!Set(socket, SOL_SOCKET, SO_REUSEADDR, 1)) return Failed("share the port");
  // Without it the socket hears the group also where anybody else on this host has joined it.
  if (!Set(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0)) return Failed("hear the loopback interface alone");
  DADRL_RETURN_IF_ERROR(Bind(socket, group));
  if (!Set(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, OnLoopback(group))) return Failed("join");
  return socket;
}

Result<FileDescriptor> OpenMulticastSender(const sockaddr_in& group) {
  DADRL_ASSIGN_OR_RETURN(FileDescriptor socket, UdpSocket());
  sockaddr_in loopback{};
  loopback.sin_family = AF_INET;
  loopback.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  DADRL_RETURN_IF_ERROR(Bind(socket, loopback));
  if (!Set(socket, IPPROTO_IP, IP_MULTICAST_IF, OnLoopback(group))) return Failed("send by loopback");
  if (!Set(socket, IPPROTO_IP, IP_MULTICAST_TTL, 0)) return Failed("keep on this host");
  // The kernel delivers a group only on interfaces where somebody has joined it; LCM's own tools join
  // elsewhere, and hear this all the same.
  if (!Set(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, OnLoopback(group))) return Failed("join");
  return socket;
}

bool IsThisHost(const sockaddr_in& address) {
  return address.sin_family == AF_INET && ntohl(address.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
}

Status HearOwnMulticast(const sockaddr_in& group) {
  sockaddr_in to = group;
  to.sin_port = 0;
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor receiver, OpenMulticastReceiver(to));
  DADRL_ASSIGN_OR_RETURN(const FileDescriptor sender, OpenMulticastSender(to));
  socklen_t length = sizeof(to);
  if (getsockname(receiver.get(), reinterpret_cast<sockaddr*>(&to), &length) != 0) return Failed("port");
  constexpr std::array<char, 6> kProbe = {'d', 'a', 'd', 'r', 'l', '?'};
  for (int i = 0; i < kAttempts; ++i) {
    if (sendto(sender.get(), kProbe.data(), kProbe.size(), 0, reinterpret_cast<const sockaddr*>(&to),
               sizeof(to)) < 0) {
      return Failed("send");
    }
    pollfd heard{.fd = receiver.get(), .events = POLLIN, .revents = 0};
    if (poll(&heard, 1, kWait_ms) == 1) return {};
  }
  return Fail(ErrorCode::kUnavailable, "what it sends does not come back");
}

}  // namespace dadrl
