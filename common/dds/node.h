// One process's place in the cluster: a participant in the data domain and one in the control domain.
//
// Two domains, because a full reader starves every other topic that its process receives in the same domain.
// Discovery is a star of unicast peers: replay shards and the learner stand at known ports, actors take any
// port and know only those.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <memory>
#include <string>

#include "common/config/config.h"
#include "common/util/result.h"

namespace dadrl::dds {

enum class Role : uint32_t { kReplay = 0, kLearner = 1, kActor = 2, kMonitor = 3 };
enum class Plane { kData, kControl };

// The Cyclone DDS configuration of one domain of one process, as XML. Ports: base + 100 * plane + 10 + 2 *
// place. `receive_buffer_bytes` of 0 leaves the system's default.
std::string DomainXml(const ClusterConfig& cluster, int replay_shards, Role role, int index, Plane plane,
                      int64_t receive_buffer_bytes);

// Thread safe after creation. At most one a process.
class Node {
 public:
  // `index`: shard number of a replay, id of an actor, 0 otherwise. kUnavailable when a port is taken; a
  // receive buffer that the host forbids is a warning and the system's default.
  static Result<std::unique_ptr<Node>> Create(const ClusterConfig& cluster, int replay_shards, Role role,
                                              int index);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  dds_entity_t participant(Plane plane) const { return plane == Plane::kData ? data_ : control_; }

 private:
  Node() = default;
  dds_entity_t data_ = 0;
  dds_entity_t control_ = 0;
};

// First of a block of free UDP ports (200 of them) on this host for ClusterConfig::port.
Result<int> FindFreePort();

}  // namespace dadrl::dds
