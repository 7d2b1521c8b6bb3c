// Cyclone DDS binds the sockets on which it receives to every address of the machine, and has no setting for
// it: a cluster on 127.0.0.1 could be reached from the network.
#pragma once

#include <netinet/in.h>

namespace dadrl::dds {

// While it lives, UDP sockets that this thread binds to every address are bound to `address` alone: this
// program's own bind() comes before the C library's. Not nested.
class BoundSockets {
 public:
  explicit BoundSockets(in_addr_t address);
  ~BoundSockets();
  BoundSockets(const BoundSockets&) = delete;
  BoundSockets& operator=(const BoundSockets&) = delete;
};

}  // namespace dadrl::dds
