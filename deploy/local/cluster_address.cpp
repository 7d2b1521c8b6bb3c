#include "deploy/local/cluster_address.h"

#include <algorithm>

namespace dadrl {
namespace {

constexpr const char* kLoopback = "127.0.0.1";

// "192.0.2.2 (eth0), 127.0.0.1 (this machine alone)".
std::string Choices(const std::vector<dds::LocalAddress>& local) {
  std::string text;
  for (const dds::LocalAddress& entry : local) {
    if (!dds::IsLoopback(entry.address)) text += fmt::format("{} ({}), ", entry.address, entry.interface);
  }
  return text + kLoopback + " (this machine alone)";
}

}  // namespace

Status CheckClusterAddress(const std::string& host, const std::string& address,
                           const std::vector<dds::LocalAddress>& local) {
  if (address == kLoopback && (host == kLoopback || host == "localhost")) return {};
  const std::string named = host == address ? host : fmt::format("{} ({} here)", host, address);
  if (dds::IsLoopback(address)) {
    return Fail(ErrorCode::kInvalidArgument,
                "cluster.host: {} is an address that no other machine reaches (names: see /etc/hosts); this "
                "machine has {}",
                named, Choices(local));
  }
  const bool ours = std::any_of(local.begin(), local.end(),
                                [&](const dds::LocalAddress& entry) { return entry.address == address; });
  if (ours) return {};
  return Fail(
      ErrorCode::kInvalidArgument,
      "cluster.host: {} is no address of this machine, where the replay and the learner run; it has {}",
      named, Choices(local));
}

Result<std::string> ClusterAddress(const std::string& host) {
  DADRL_ASSIGN_OR_RETURN(std::string address, dds::ResolveHost(host));
  DADRL_RETURN_IF_ERROR(CheckClusterAddress(host, address, dds::LocalAddresses()));
  return address;
}

}  // namespace dadrl
