// One process's place in the cluster: a participant in each domain that its role uses.
//
// Three domains, because a full reader starves every other topic that its process receives in the same
// domain, the acknowledgements of what it sends there included: a replay that cannot store for a while would
// send no batches either. Nothing in the control domain can be full (TopicSpec).
// Discovery is a star of unicast peers: replay shards and the learner stand at known ports, actors take any
// port and know only those.
#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>

#include "common/config/config.h"
#include "common/port/port.h"
#include "common/util/enum_array.h"
#include "common/util/result.h"

namespace dadrl::dds {

enum class Role : uint32_t { kReplay = 0, kLearner = 1, kActor = 2, kMonitor = 3 };
// Each plane is a DDS domain.
constexpr std::array kPlanes = {Plane::kExperience, Plane::kControl, Plane::kBatches};

// Most replay shards that the ports of a cluster have room for.
constexpr int kMaxShards = 24;
// Ports that a cluster owns from ClusterConfig::port on, and those of one plane among them.
constexpr int kPortBlock = 200;
constexpr int kPlanePorts = 60;

// Replay shards and the learner: those that others find at well-known ports.
bool IsService(Role role);
// Where a service stands among them: shard i at i, the learner after the last shard.
int PlaceOf(Role role, int index, int replay_shards);
// Whether processes of this role take part in the plane.
bool Uses(Role role, Plane plane);

// Where FindFreePort looks: below the ports that Linux hands out by itself (32768 and up), so that a block
// stays free once it is chosen.
constexpr int kFirstPort = 10000;
constexpr int kBlocks = 113;

// Well-known ports stand at base + kPlanePorts * plane + 10 + 2 * place (discovery) and one above (data).
int WellKnownPort(const ClusterConfig& cluster, Plane plane, int place);

// How one process stands in the network.
struct Place {
  std::string address;   // IPv4, to send from and be reached at
  int mtu = 0;           // longest IP packet that leaves whole; 0: unknown
  std::string tag = {};  // only who shows the same one is heard; "": none
};

// The Cyclone DDS configuration of one domain of one process, as XML.
std::string DomainXml(const ClusterConfig& cluster, int replay_shards, Role role, int index, Plane plane,
                      const Place& place);

// Thread safe after creation; outlives its endpoints. Several nodes may live in one process (tests do). The
// environment's CYCLONEDDS_URI is ignored, with a notice: every setting follows from ClusterConfig.
class Node final : public Transport {
 public:
  // `index`: shard number of a replay, id of an actor, 0 otherwise. Does not wait for peers.
  // A monitor with cluster.port 0 knows shard 0 of every block that FindFreePort may have given out.
  // `key` is the run's (common/io/run_key.h): on loopback, and elsewhere when cluster.require_key is set,
  // nodes find only those that have the same one; "": those that have none. Every socket is bound to one
  // address, the one that cluster.host is reached from.
  // kInvalidArgument: cluster.host cannot be resolved, or is no address of this machine (replay and learner),
  // or cluster.port is 0 (others), or a key is required and there is none. kUnavailable: a port is taken, or
  // no way leads to cluster.host (an actor waits for one: CheckAddress). Of a receive buffer that the host
  // forbids it takes what it gets, with a warning.
  static Result<std::unique_ptr<Node>> Create(const ClusterConfig& cluster, int replay_shards, Role role,
                                              int index, const std::string& key = {});
  ~Node() override;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  Result<std::unique_ptr<WriterPort>> OpenWriter(const TopicSpec& topic) const override;
  Result<std::unique_ptr<ReaderPort>> OpenReader(const TopicSpec& topic) const override;

  // 0 in a plane that the role does not use.
  dds_entity_t participant(Plane plane) const { return planes_[plane].participant; }
  // kUnavailable when this machine no longer has the node's address and reaches the cluster from another:
  // only a new node is heard then.
  Status CheckAddress() const;

 private:
  struct Domain {
    dds_entity_t domain = 0;
    dds_entity_t participant = 0;
    // All its sockets are bound to `address`.
    Status Open(const std::string& xml, const std::string& address);
  };

  Node(const ClusterConfig& cluster, std::string address)
      : host_(cluster.host), address_(std::move(address)) {}

  EnumArray<Plane, Domain, kPlanes.size()> planes_{};
  std::string host_;     // the cluster's, in dotted form
  std::string address_;  // this node's
};

// First of a block of kPortBlock free UDP ports on this host, for ClusterConfig::port. The block stays
// reserved against other callers of FindFreePort, in any process, until this process ends.
Result<int> FindFreePort();

}  // namespace dadrl::dds
