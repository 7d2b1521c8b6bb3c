#include "common/telemetry/multicast_probe.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "common/io/file_descriptor.h"

namespace dadrl {
namespace {

// A packet may be lost, and the host may be busy.
constexpr int kAttempts = 5;
constexpr int kWait_ms = 50;

tl::unexpected<Error> Failed(const char* what) {
  return Fail(ErrorCode::kUnavailable, "{}: {}", what, std::strerror(errno));
}

FileDescriptor UdpSocket() { return FileDescriptor(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)); }

// Listens to `group` on a port that the system chooses; fills in the port.
Status Join(const FileDescriptor& receiver, sockaddr_in& group) {
  sockaddr_in any{};
  any.sin_family = AF_INET;
  if (bind(receiver.get(), reinterpret_cast<const sockaddr*>(&any), sizeof(any)) != 0) return Failed("bind");
  socklen_t length = sizeof(any);
  if (getsockname(receiver.get(), reinterpret_cast<sockaddr*>(&any), &length) != 0) return Failed("port");
  group.sin_port = any.sin_port;
  const ip_mreq membership{.imr_multiaddr = group.sin_addr, .imr_interface = {INADDR_ANY}};
  if (setsockopt(receiver.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) != 0) {
    return Failed("join");
  }
  return {};
}

}  // namespace

Status HearOwnMulticast(const std::string& group) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  if (inet_pton(AF_INET, group.c_str(), &to.sin_addr) != 1) {
    return Fail(ErrorCode::kUnavailable, "'{}' is no address", group);
  }
  const FileDescriptor receiver = UdpSocket();
  const FileDescriptor sender = UdpSocket();
  if (!receiver.valid() || !sender.valid()) return Failed("socket");
  DADRL_RETURN_IF_ERROR(Join(receiver, to));
  const uint8_t ttl = 0;
  setsockopt(sender.get(), IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof(ttl));
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
