// Multicast that stays on this host: sockets on the loopback interface alone.
//
// What is sent here leaves by the loopback interface and no other, and what is received has come by it: no
// packet of another machine arrives, nor one that is sent to an address of this host instead of the group.
#pragma once

#include <netinet/in.h>

#include <string_view>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// "udpm://239.255.76.67:7667?..." as LCM writes it; what follows the port is ignored.
// kInvalidArgument when it is no multicast group and port.
Result<sockaddr_in> ParseMulticastUrl(std::string_view url);

// A non-blocking socket bound to the group, a member on the loopback interface only. Others may listen
// beside. kUnavailable with the reason where the host does not allow it.
Result<FileDescriptor> OpenMulticastReceiver(const sockaddr_in& group);

// A socket to sendto(group) from.
Result<FileDescriptor> OpenMulticastSender(const sockaddr_in& group);

// True when `address` is one that only this host can have (127.0.0.0/8), as all that OpenMulticastSender
// sends.
bool IsThisHost(const sockaddr_in& address);

// Sends a packet to the group's address, on a port of its own, and listens for it. kUnavailable with the
// reason when it does not come back within a quarter of a second.
Status HearOwnMulticast(const sockaddr_in& group);

}  // namespace dadrl
