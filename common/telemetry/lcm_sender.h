// Sends packets that LCM's tools on this host hear, and nobody beyond it.
#pragma once

#include <netinet/in.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <span>
#include <string>

#include "common/io/file_descriptor.h"
#include "common/util/result.h"

namespace dadrl {

// Thread safe.
class LcmSender {
 public:
  // `url`: "udpm://239.255.76.67:PORT". kUnavailable when this host does not hear its own multicast (found
  // out here, in a quarter of a second).
  static Result<std::unique_ptr<LcmSender>> Open(const std::string& url);

  // Never blocks; a packet may be lost without a word. kUnavailable when the system refused it,
  // kInvalidArgument when it is too long for one datagram.
  Status Publish(const std::string& channel, std::span<const std::byte> packet);

 private:
  LcmSender(const sockaddr_in& group, FileDescriptor socket) : group_(group), socket_(std::move(socket)) {}

  const sockaddr_in group_;
  const FileDescriptor socket_;
  std::atomic<uint32_t> sequence_{0};
};

}  // namespace dadrl
