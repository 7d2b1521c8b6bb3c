// The address of a multicast group, as LCM writes it.
#include <arpa/inet.h>

#include <string>

#include "common/telemetry/multicast.h"
#include "tests/fuzz/harness.h"

namespace dadrl::fuzz {
namespace {

Bytes Input(const std::string& url) {
  const auto bytes = std::as_bytes(std::span(url));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

const int kMutants = 200000;

bool Check(std::span<std::byte> input) {
  const std::string_view url(reinterpret_cast<const char*>(input.data()), input.size());
  const auto group = ParseMulticastUrl(url);
  if (!group) return false;
  Require(group->sin_family == AF_INET && IN_MULTICAST(ntohl(group->sin_addr.s_addr)));
  char text[INET_ADDRSTRLEN] = {};
  Require(inet_ntop(AF_INET, &group->sin_addr, text, sizeof(text)) != nullptr);
  const auto again = ParseMulticastUrl(fmt::format("udpm://{}:{}", text, ntohs(group->sin_port)));
  Require(again && again->sin_addr.s_addr == group->sin_addr.s_addr && again->sin_port == group->sin_port);
  return true;
}

Seeds MakeSeeds() {
  Seeds seeds;
  for (const char* url :
       {"udpm://239.255.76.67:7667?ttl=0", "udpm://224.0.0.1:1", "udpm://239.0.0.1:65535?"}) {
    seeds.accepted.push_back(Input(url));
  }
  for (const char* url : {"", "udpm://", "udpm://10.0.0.1:1", "udpm://239.255.76.67:70000", "memq://",
                          "udpm://239.255.76.67?:1", "udpm://239.255.76.67:-1"}) {
    seeds.refused.push_back(Input(url));
  }
  return seeds;
}

}  // namespace dadrl::fuzz
