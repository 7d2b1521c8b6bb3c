#include "common/telemetry/lcm_sender.h"

#include <sys/socket.h>

#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "common/telemetry/lcm_message.h"
#include "common/telemetry/multicast.h"

namespace dadrl {

Result<std::unique_ptr<LcmSender>> LcmSender::Open(const std::string& url) {
  DADRL_ASSIGN_OR_RETURN(const sockaddr_in group, ParseMulticastUrl(url));
  Status heard = HearOwnMulticast(group);
  Result<FileDescriptor> socket = OpenMulticastSender(group);
  if (heard && !socket) heard = tl::unexpected(socket.error());
  if (!heard) {
    return Fail(ErrorCode::kUnavailable,
                "no LCM at {}: this host does not hear its own multicast ({}); as root: ip link set lo up",
                url, heard.error().message);
  }
  return std::unique_ptr<LcmSender>(new LcmSender(group, std::move(*socket)));
}

Status LcmSender::Publish(const std::string& channel, std::span<const std::byte> packet) {
  DADRL_ASSIGN_OR_RETURN(
      const std::vector<std::byte> datagram,
      EncodeLcmMessage({.sequence = sequence_.fetch_add(1), .channel = channel, .packet = packet}));
  if (sendto(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&group_),
             sizeof(group_)) >= 0) {
    return {};
  }
  return Fail(ErrorCode::kUnavailable, "LCM packet on {} was refused by the system: {}", channel,
              std::strerror(errno));
}

}  // namespace dadrl
