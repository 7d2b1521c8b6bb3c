#include "common/telemetry/lcm_receiver.h"

#include <poll.h>
#include <sys/socket.h>

#include <algorithm>
#include <utility>

#include "common/telemetry/multicast.h"
#include "common/util/log.h"

namespace dadrl {
namespace {

constexpr size_t kMaxDatagram = 65536;

}  // namespace

Result<std::unique_ptr<LcmReceiver>> LcmReceiver::Open(const std::string& url) {
  DADRL_ASSIGN_OR_RETURN(const sockaddr_in group, ParseMulticastUrl(url));
  Status heard = HearOwnMulticast(group);
  Result<FileDescriptor> socket = OpenMulticastReceiver(group);
  if (heard && !socket) heard = tl::unexpected(socket.error());
  if (!heard) {
    return Fail(ErrorCode::kUnavailable,
                "no LCM at {}: this host does not hear its own multicast ({}); as root: ip link set lo up",
                url, heard.error().message);
  }
  return std::unique_ptr<LcmReceiver>(new LcmReceiver(std::move(*socket)));
}

LcmReceiver::LcmReceiver(FileDescriptor socket) : socket_(std::move(socket)), buffer_(kMaxDatagram) {}

bool LcmReceiver::Receive(Duration timeout, const Handler& handler) {
  const auto whole = std::chrono::ceil<std::chrono::milliseconds>(timeout).count();
  pollfd ready{.fd = socket_.get(), .events = POLLIN, .revents = 0};
  if (poll(&ready, 1, static_cast<int>(std::clamp<int64_t>(whole, 0, 3'600'000))) != 1) return false;
  sockaddr_in source{};
  socklen_t length = sizeof(source);
  const ssize_t size = recvfrom(socket_.get(), buffer_.data(), buffer_.size(), 0,
                                reinterpret_cast<sockaddr*>(&source), &length);
  if (size < 0) return false;
  if (!IsThisHost(source)) {
    Refuse(LcmRefusal::kStranger);
    return true;
  }
  const auto message = ParseLcmMessage(std::span(buffer_).first(static_cast<size_t>(size)));
  if (!message) {
    Refuse(message.error());
  } else if (!handler(*message)) {
    Refuse(LcmRefusal::kChannel);
  }
  return true;
}

void LcmReceiver::Refuse(LcmRefusal refusal) {
  if (++refusals_[refusal] > 1) return;
  spdlog::warn("telemetry: refused a datagram ({}): somebody else sends to this group and port",
               LcmRefusalName(refusal));
}

}  // namespace dadrl
