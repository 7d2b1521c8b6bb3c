// IPv4 addresses and UDP ports of this machine, as the star of peers needs them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/util/result.h"

namespace dadrl::dds {

// The IPv4 address of `host` (a name or an address) in dotted form. Blocks on the resolver.
// kInvalidArgument when it has none.
Result<std::string> ResolveHost(const std::string& host);

// True for 127.0.0.0/8 in dotted form.
bool IsLoopback(const std::string& address);

// True when sockets of this machine can be bound to `address`.
bool IsLocalAddress(const std::string& address);

// One IPv4 address of this machine.
struct LocalAddress {
  std::string interface;  // "eth0"
  std::string address;
  int mtu = 0;  // bytes of the longest IP packet
};
// Those of the interfaces that are up.
std::vector<LocalAddress> LocalAddresses();

// The local address from which packets to `address` leave; "" when there is no route.
std::string SourceAddressTowards(const std::string& address);

// True when nothing is bound to UDP `port` on any address of this machine.
bool IsUdpPortFree(int port);

// What this host grants of a UDP receive buffer of `bytes`.
int64_t GrantedReceiveBuffer(int64_t bytes);

}  // namespace dadrl::dds
