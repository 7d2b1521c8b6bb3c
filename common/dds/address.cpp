#include "common/dds/address.h"

#include <ifaddrs.h>
#include <net/if.h>
#include <netdb.h>
#include <sys/ioctl.h>

#include <cstring>
#include <memory>

#include "common/dds/udp_socket.h"

namespace dadrl::dds {
namespace {

std::string Dotted(in_addr address) {
  char text[INET_ADDRSTRLEN] = {};
  ::inet_ntop(AF_INET, &address, text, sizeof(text));
  return text;
}

int MtuOf(const char* interface) {
  ifreq request{};
  std::strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
  const UdpSocket socket;
  return ::ioctl(socket.descriptor(), SIOCGIFMTU, &request) == 0 ? request.ifr_mtu : 0;
}

}  // namespace

Result<std::string> ResolveHost(const std::string& host) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_DGRAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
  if (error != 0) {
    return Fail(ErrorCode::kInvalidArgument, "cluster.host: '{}' has no IPv4 address: {}", host,
                ::gai_strerror(error));
  }
  const std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)> owner(found, &::freeaddrinfo);
  return Dotted(reinterpret_cast<const sockaddr_in*>(found->ai_addr)->sin_addr);
}

bool IsLoopback(const std::string& address) { return address.starts_with("127."); }

bool IsLocalAddress(const std::string& address) {
  const in_addr_t binary = ::inet_addr(address.c_str());
  return binary != INADDR_ANY && UdpSocket().Bind(0, binary);
}

std::vector<LocalAddress> LocalAddresses() {
  std::vector<LocalAddress> addresses;
  ifaddrs* found = nullptr;
  if (::getifaddrs(&found) != 0) return addresses;
  const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(found, &::freeifaddrs);
  for (const ifaddrs* entry = found; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    if ((entry->ifa_flags & IFF_UP) == 0) continue;
    const auto& name = *reinterpret_cast<const sockaddr_in*>(entry->ifa_addr);
    addresses.push_back({entry->ifa_name, Dotted(name.sin_addr), MtuOf(entry->ifa_name)});
  }
  return addresses;
}

std::string SourceAddressTowards(const std::string& address) {
  const UdpSocket socket;
  // Connecting a UDP socket sends nothing; it asks the kernel for the route. Any port will do.
  const sockaddr_in peer = SocketAddress(::inet_addr(address.c_str()), 9);
  if (::connect(socket.descriptor(), reinterpret_cast<const sockaddr*>(&peer), sizeof(peer)) != 0) return {};
  sockaddr_in name{};
  socklen_t length = sizeof(name);
  if (::getsockname(socket.descriptor(), reinterpret_cast<sockaddr*>(&name), &length) != 0) return {};
  return Dotted(name.sin_addr);
}

bool IsUdpPortFree(int port) { return UdpSocket().Bind(port); }

int64_t GrantedReceiveBuffer(int64_t bytes) {
  const UdpSocket socket;
  const int wanted = static_cast<int>(bytes);
  ::setsockopt(socket.descriptor(), SOL_SOCKET, SO_RCVBUF, &wanted, sizeof(wanted));
  int granted = 0;
  socklen_t length = sizeof(granted);
  ::getsockopt(socket.descriptor(), SOL_SOCKET, SO_RCVBUF, &granted, &length);
  return granted / 2;  // Linux reports twice what it counts for payload
}

}  // namespace dadrl::dds
