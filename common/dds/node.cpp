#include "common/dds/node.h"

#include <arpa/inet.h>

#include <cstdlib>
#include <tuple>
#include <utility>

#include "common/dds/address.h"
#include "common/dds/bound_sockets.h"
#include "common/dds/cluster_key.h"
#include "common/dds/log_sink.h"
#include "common/dds/steady_wait.h"
#include "common/util/log.h"

namespace dadrl::dds {
namespace {

constexpr dds_domainid_t kMaxDomainId = 230;
// Where an actor stands while no way leads to the cluster.
constexpr const char* kNowhere = "127.0.0.1";

// Creates a domain under any id that is free inside this process. Returns Cyclone's error when it fails.
dds_entity_t CreateDomain(const std::string& xml) {
  for (dds_domainid_t id = 0; id <= kMaxDomainId; ++id) {
    const dds_entity_t domain = dds_create_domain(id, xml.c_str());
    if (domain != DDS_RETCODE_PRECONDITION_NOT_MET) return domain;
  }
  return DDS_RETCODE_OUT_OF_RESOURCES;
}

Status CheckPortsFree(const ClusterConfig& cluster, int place, Plane plane) {
  const int first = WellKnownPort(cluster, plane, place);
  for (int port = first; port <= first + 1; ++port) {
    if (!IsUdpPortFree(port)) {
      return Fail(ErrorCode::kUnavailable,
                  "UDP port {} is taken, perhaps by another cluster: stop it, or set cluster.port (now {})",
                  port, cluster.port);
    }
  }
  return {};
}

Status CheckArguments(const ClusterConfig& cluster, int replay_shards, Role role, int index) {
  const bool scout = role == Role::kMonitor && cluster.port == 0;
  if ((cluster.port <= 0 && !scout) || cluster.port + kPortBlock > 65536) {
    return Fail(ErrorCode::kInvalidArgument, "cluster.port: {} leaves no room for {} ports below 65536",
                cluster.port, kPortBlock);
  }
  if (replay_shards < 1 || replay_shards > kMaxShards) {
    return Fail(ErrorCode::kInvalidArgument, "replay.shards: {} is not between 1 and {}", replay_shards,
                kMaxShards);
  }
  if (index < 0 || (role == Role::kReplay && index >= replay_shards)) {
    return Fail(ErrorCode::kInvalidArgument, "shard {} does not exist: replay.shards is {}", index,
                replay_shards);
  }
  return {};
}

// The address to send from and be reached at.
Result<std::string> InterfaceAddress(const ClusterConfig& cluster, Role role) {
  if (IsService(role)) {
    if (IsLocalAddress(cluster.host)) return cluster.host;
    return Fail(ErrorCode::kInvalidArgument,
                "cluster.host: {} is no address of this machine; the replay and the learner run where it is",
                cluster.host);
  }
  std::string address = SourceAddressTowards(cluster.host);
  if (!address.empty()) return address;
  if (role == Role::kActor) return std::string(kNowhere);  // CheckAddress tells when there is a way
  return Fail(ErrorCode::kUnavailable, "no way leads from this machine to {}: is its network up?",
              cluster.host);
}

int MtuFrom(const std::string& address) {
  for (const LocalAddress& local : LocalAddresses()) {
    if (local.address == address) return local.mtu;
  }
  return 0;
}

// `cluster.host` in dotted form.
Result<Place> FindPlace(const ClusterConfig& cluster, Role role, const std::string& key) {
  Place place;
  DADRL_ASSIGN_OR_RETURN(place.address, InterfaceAddress(cluster, role));
  place.mtu = cluster.mtu > 0 ? cluster.mtu : MtuFrom(place.address);
  if (cluster.require_key && key.empty()) {
    return Fail(ErrorCode::kInvalidArgument,
                "cluster.require_key is set, and there is no key: the run's is in RUN/key");
  }
  if (AsksForKey(cluster)) place.tag = key;
  return place;
}

void WarnOfSmallReceiveBuffer(int64_t wanted) {
  const int64_t granted = GrantedReceiveBuffer(wanted);
  if (granted >= wanted) return;
  spdlog::warn(
      "this host grants a UDP receive buffer of {} bytes, {} wanted: transfers may be slow; as root: "
      "sysctl -w net.core.rmem_max={}",
      granted, wanted, wanted);
}

void NoticeIgnoredEnvironment() {
  static const bool noticed = [] {
    const char* uri = std::getenv("CYCLONEDDS_URI");
    if (uri != nullptr && *uri != '\0') {
      spdlog::info("CYCLONEDDS_URI is ignored: the cluster's DDS settings come from its configuration");
    }
    return true;
  }();
  std::ignore = noticed;
}

}  // namespace

Result<std::unique_ptr<Node>> Node::Create(const ClusterConfig& config, int replay_shards, Role role,
                                           int index, const std::string& key) {
  WaitSteadily();
  InstallLogSink();
  NoticeIgnoredEnvironment();
  DADRL_RETURN_IF_ERROR(CheckArguments(config, replay_shards, role, index));
  ClusterConfig cluster = config;
  DADRL_ASSIGN_OR_RETURN(cluster.host, ResolveHost(config.host));
  DADRL_ASSIGN_OR_RETURN(const Place place, FindPlace(cluster, role, key));

  std::unique_ptr<Node> node(new Node(cluster, place.address));
  WarnOfSmallReceiveBuffer(cluster.receive_buffer_bytes);
  for (const Plane plane : kPlanes) {
    if (!Uses(role, plane)) continue;
    if (IsService(role)) {
      DADRL_RETURN_IF_ERROR(CheckPortsFree(cluster, PlaceOf(role, index, replay_shards), plane));
    }
    DADRL_RETURN_IF_ERROR(node->planes_[plane].Open(
        DomainXml(cluster, replay_shards, role, index, plane, place), place.address));
  }
  return node;
}

Status Node::Domain::Open(const std::string& xml, const std::string& address) {
  const BoundSockets bound(::inet_addr(address.c_str()));
  domain = CreateDomain(xml);
  dds_domainid_t id = 0;
  participant =
      dds_get_domainid(domain, &id) == DDS_RETCODE_OK ? dds_create_participant(id, nullptr, nullptr) : domain;
  if (participant < 0) {
    spdlog::debug("settings of DDS: {}", xml);
    return Fail(ErrorCode::kInternal, "cannot start DDS at {}: {} (the lines above say why)", address,
                dds_strretcode(participant));
  }
  return {};
}

Status Node::CheckAddress() const {
  const bool nowhere = address_ == kNowhere && !IsLoopback(host_);
  if (!nowhere && IsLocalAddress(address_)) return {};
  const std::string now = SourceAddressTowards(host_);
  if (now.empty() || now == address_) return {};
  return Fail(ErrorCode::kUnavailable,
              "this machine's address towards the cluster at {} was {} and is {} now: starting anew", host_,
              nowhere ? "none" : address_, now);
}

Node::~Node() {
  // Cyclone wakes its threads with a packet to the node's address, and would wait for them in vain. Who loses
  // an address ends.
  if (!IsLocalAddress(address_)) return;
  for (const Domain& plane : planes_) {
    if (plane.domain > 0) dds_delete(plane.domain);
  }
}

}  // namespace dadrl::dds
