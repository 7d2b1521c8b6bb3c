#include <random>

#include "common/dds/address.h"
#include "common/dds/node.h"
#include "common/dds/udp_socket.h"

namespace dadrl::dds {
namespace {

// Nothing else binds the first port of a block (it would be Cyclone's multicast port), so a socket bound
// there reserves the whole block; on loopback, where nobody else can send to it.
bool TryReserveBlock(int base) {
  UdpSocket reservation;
  if (!IsUdpPortFree(base) || !reservation.Bind(base, htonl(INADDR_LOOPBACK))) return false;
  for (int port = base + 1; port < base + kPortBlock; ++port) {
    if (!IsUdpPortFree(port)) return false;
  }
  reservation.Release();  // stays bound until the process ends
  return true;
}

}  // namespace

Result<int> FindFreePort() {
  const int start = static_cast<int>(std::random_device()() % kBlocks);
  for (int i = 0; i < kBlocks; ++i) {
    const int base = kFirstPort + (start + i) % kBlocks * kPortBlock;
    if (TryReserveBlock(base)) return base;
  }
  return Fail(ErrorCode::kUnavailable,
              "no {} consecutive free UDP ports between {} and {}: stop other clusters or set cluster.port",
              kPortBlock, kFirstPort, kFirstPort + kBlocks * kPortBlock);
}

}  // namespace dadrl::dds
