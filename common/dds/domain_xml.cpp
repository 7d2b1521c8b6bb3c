#include <fmt/format.h>

#include <algorithm>

#include "common/dds/address.h"
#include "common/dds/node.h"

namespace dadrl::dds {
namespace {

// Room for a bounded sequence of 64 MiB (cluster.idl) and its header; Cyclone's own default is 2 GB.
constexpr const char* kMaxSampleSize = "65 MiB";

std::string PeerXml(const ClusterConfig& cluster, Plane plane, int place) {
  return fmt::format("<Peer Address=\"{}:{}\"/>", cluster.host, WellKnownPort(cluster, plane, place));
}

// Everyone speaks first to the services; the services answer and speak to each other. Actors and monitors
// know nobody else, so discovery stays linear in their number.
std::string PeersXml(const ClusterConfig& cluster, int replay_shards, Role role, int index, Plane plane) {
  std::string peers;
  for (int block = 0; cluster.port == 0 && block < kBlocks; ++block) {
    ClusterConfig candidate = cluster;
    candidate.port = kFirstPort + block * kPortBlock;
    peers += PeerXml(candidate, plane, 0);
  }
  const int places = replay_shards + (Uses(Role::kLearner, plane) ? 1 : 0);
  for (int place = 0; cluster.port > 0 && place < places; ++place) {
    if (IsService(role) && place == PlaceOf(role, index, replay_shards)) continue;
    peers += PeerXml(cluster, plane, place);
  }
  return peers;
}

// IP and UDP.
constexpr int kPacketHeaders = 28;
// What RTPS puts before a fragment: its header, destination, time stamp, the fragment's own, inline QoS.
constexpr int kMessageHeaders = 160;
// Of Ethernet, where the interface does not tell.
constexpr int kUsualMtu = 1500;
constexpr int kSmallestMtu = 576;        // that every IPv4 host takes
constexpr int kLongestMessage = 65'500;  // of UDP, nearly

std::string SizesXml(const ClusterConfig& cluster, int mtu) {
  if (IsLoopback(cluster.host)) {
    return fmt::format("<MaxMessageSize>{} B</MaxMessageSize><FragmentSize>65000 B</FragmentSize>",
                       kLongestMessage);
  }
  const int packet = mtu > 0 ? std::max(mtu, kSmallestMtu) : kUsualMtu;
  const int message = std::min(packet - kPacketHeaders, kLongestMessage);
  return fmt::format(
      "<MaxMessageSize>{} B</MaxMessageSize><MaxRexmitMessageSize>{} B</MaxRexmitMessageSize>"
      "<FragmentSize>{} B</FragmentSize>",
      message, message, message - kMessageHeaders);
}

// On loopback large fragments are several times faster. On a network one lost frame would cost all that was
// sent with it, and some paths drop IP fragments altogether: a message fits a packet there.
std::string GeneralXml(const ClusterConfig& cluster, const Place& place) {
  return fmt::format(
      "<AllowMulticast>false</AllowMulticast>"
      "<Interfaces><NetworkInterface address=\"{}\"/></Interfaces>{}",
      place.address, SizesXml(cluster, place.mtu));
}

// `max` is what Cyclone asks for and takes less of; with `min` it would refuse to start where the host
// forbids it.
std::string InternalXml(int64_t receive_buffer_bytes) {
  return fmt::format("<MaxSampleSize>{}</MaxSampleSize><SocketReceiveBufferSize max=\"{} B\"/>",
                     kMaxSampleSize, receive_buffer_bytes);
}

}  // namespace

bool IsService(Role role) { return role == Role::kReplay || role == Role::kLearner; }

bool Uses(Role role, Plane plane) {
  switch (plane) {
    case Plane::kExperience:
      return role == Role::kReplay || role == Role::kActor;
    case Plane::kControl:
      return true;
    case Plane::kBatches:
      return role == Role::kReplay || role == Role::kLearner;
  }
  return false;
}

int PlaceOf(Role role, int index, int replay_shards) { return role == Role::kReplay ? index : replay_shards; }

int WellKnownPort(const ClusterConfig& cluster, Plane plane, int place) {
  return cluster.port + kPlanePorts * static_cast<int>(plane) + 10 + 2 * place;
}

std::string DomainXml(const ClusterConfig& cluster, int replay_shards, Role role, int index, Plane plane,
                      const Place& place) {
  const std::string participant =
      IsService(role) ? fmt::format("{}", PlaceOf(role, index, replay_shards)) : "none";
  // ExternalDomainId: the id on the wire; the id inside the process is free to differ, so that tests can hold
  // several nodes. A short SPDP interval lets a restarted service be found within a second. Warnings reach
  // the log through InstallLogSink; Cyclone's own trace file would appear in whatever folder we were started
  // from.
  return fmt::format(
      "<CycloneDDS><Domain Id=\"any\">"
      "<General>{}</General>"
      "<Discovery><Tag>{}</Tag><ExternalDomainId>{}</ExternalDomainId><ParticipantIndex>{}</ParticipantIndex>"
      "<Peers>{}</Peers><LeaseDuration>{} s</LeaseDuration><SPDPInterval>1 s</SPDPInterval>"
      "<Ports><Base>{}</Base><DomainGain>{}</DomainGain><ParticipantGain>2</ParticipantGain>"
      "<MulticastMetaOffset>0</MulticastMetaOffset><MulticastDataOffset>1</MulticastDataOffset>"
      "<UnicastMetaOffset>10</UnicastMetaOffset><UnicastDataOffset>11</UnicastDataOffset></Ports></Discovery>"
      "<Internal>{}</Internal>"
      "<Tracing><Verbosity>warning</Verbosity><OutputFile>/dev/null</OutputFile></Tracing>"
      "</Domain></CycloneDDS>",
      GeneralXml(cluster, place), place.tag, static_cast<int>(plane), participant,
      PeersXml(cluster, replay_shards, role, index, plane), cluster.lease_s,
      cluster.port > 0 ? cluster.port : kFirstPort, kPlanePorts, InternalXml(cluster.receive_buffer_bytes));
}

}  // namespace dadrl::dds
