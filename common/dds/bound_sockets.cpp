#include "common/dds/bound_sockets.h"

#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstring>

namespace {

thread_local in_addr_t instead_of_any = INADDR_ANY;

}  // namespace

// Shared libraries look a function up in the program first, so Cyclone's calls come here as well.
extern "C" __attribute__((visibility("default"))) int bind(int socket, const sockaddr* address,
                                                           socklen_t length) noexcept {
  sockaddr_in here{};
  if (instead_of_any != INADDR_ANY && address != nullptr && length == sizeof(here) &&
      address->sa_family == AF_INET) {
    std::memcpy(&here, address, sizeof(here));
    if (here.sin_addr.s_addr == INADDR_ANY) {
      here.sin_addr.s_addr = instead_of_any;
      address = reinterpret_cast<const sockaddr*>(&here);
    }
  }
  return static_cast<int>(syscall(SYS_bind, socket, address, length));
}

namespace dadrl::dds {

BoundSockets::BoundSockets(in_addr_t address) { instead_of_any = address; }

BoundSockets::~BoundSockets() { instead_of_any = INADDR_ANY; }

}  // namespace dadrl::dds
