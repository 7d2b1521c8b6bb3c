// A UDP socket over IPv4, for questions about ports, routes and buffers.
#pragma once

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <utility>

namespace dadrl::dds {

inline sockaddr_in SocketAddress(in_addr_t address, int port) {
  sockaddr_in result{};
  result.sin_family = AF_INET;
  result.sin_addr.s_addr = address;
  result.sin_port = htons(static_cast<uint16_t>(port));
  return result;
}

class UdpSocket {
 public:
  UdpSocket() : descriptor_(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {}
  ~UdpSocket() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  UdpSocket(const UdpSocket&) = delete;
  UdpSocket& operator=(const UdpSocket&) = delete;

  int descriptor() const { return descriptor_; }
  // The caller owns the descriptor from now on.
  int Release() { return std::exchange(descriptor_, -1); }

  bool Bind(int port, in_addr_t address = INADDR_ANY) {
    const sockaddr_in name = SocketAddress(address, port);
    return ::bind(descriptor_, reinterpret_cast<const sockaddr*>(&name), sizeof(name)) == 0;
  }

 private:
  int descriptor_;
};

}  // namespace dadrl::dds
