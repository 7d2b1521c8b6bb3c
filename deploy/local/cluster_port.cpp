#include "deploy/local/cluster_port.h"

#include "common/dds/address.h"
#include "common/dds/node.h"

namespace dadrl {
namespace {

// The first taken one of the fixed ports of replay shards and learner in all domains (common/dds/node.h).
std::optional<int> TakenPort(int base, int shards) {
  ClusterConfig cluster;
  cluster.port = base;
  for (const Plane plane : dds::kPlanes) {
    for (int place = 0; place <= shards; ++place) {
      const int port = dds::WellKnownPort(cluster, plane, place);
      for (const int offset : {0, 1}) {
        if (!dds::IsUdpPortFree(port + offset)) return port + offset;
      }
    }
  }
  return std::nullopt;
}

}  // namespace

Result<int> ChoosePort(const Config& config, const std::optional<Config>& saved) {
  if (config.cluster.port == 0) return dds::FindFreePort();
  const auto taken = TakenPort(config.cluster.port, config.replay.shards);
  if (!taken) return config.cluster.port;
  if (saved && saved->cluster.port == config.cluster.port) return dds::FindFreePort();
  return Fail(ErrorCode::kUnavailable,
              "cluster.port: UDP port {} (of the block at {}) is taken: choose another, or 0 for a free one",
              *taken, config.cluster.port);
}

}  // namespace dadrl
