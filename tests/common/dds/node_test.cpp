#include "common/dds/node.h"

#include <gmock/gmock.h>

#include <cstdlib>
#include <filesystem>
#include <set>

#include "common/dds/address.h"
#include "common/dds/udp_socket.h"
#include "tests/common/dds/dds_fixture.h"
#include "tests/common/io/temporary_folder.h"
#include "tests/common/network_namespace.h"

namespace dadrl::dds {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(DomainXml, ActorsKnowTheServicesAndNobodyElse) {
  ClusterConfig cluster;
  cluster.port = 20000;
  const std::string xml = DomainXml(cluster, 2, Role::kActor, 7, Plane::kControl, {.address = "127.0.0.1"});
  EXPECT_THAT(xml, HasSubstr("<Peers><Peer Address=\"127.0.0.1:20070\"/><Peer Address=\"127.0.0.1:20072\"/>"
                             "<Peer Address=\"127.0.0.1:20074\"/></Peers>"));
  EXPECT_THAT(xml, HasSubstr("<ParticipantIndex>none</ParticipantIndex>"));
}

TEST(DomainXml, ServicesStandAtTheirPlaceAndKnowEachOther) {
  ClusterConfig cluster;
  cluster.port = 20000;
  const std::string learner =
      DomainXml(cluster, 2, Role::kLearner, 0, Plane::kBatches, {.address = "127.0.0.1"});
  EXPECT_THAT(learner, HasSubstr("<ParticipantIndex>2</ParticipantIndex>"));
  EXPECT_THAT(learner, Not(HasSubstr(":20134")));
  const std::string shard =
      DomainXml(cluster, 2, Role::kReplay, 1, Plane::kExperience, {.address = "127.0.0.1"});
  EXPECT_THAT(shard, HasSubstr("<ParticipantIndex>1</ParticipantIndex>"));
  EXPECT_THAT(shard, HasSubstr("<Peers><Peer Address=\"127.0.0.1:20010\"/></Peers>"))
      << "a learner has no part in it";
}

TEST(DomainXml, FragmentsAreLargeOnLoopbackOnly) {
  ClusterConfig cluster;
  EXPECT_THAT(
      DomainXml(cluster, 1, Role::kActor, 0, Plane::kExperience, {.address = "127.0.0.1", .mtu = 65536}),
      HasSubstr("65000 B"));
  cluster.host = "10.0.0.1";
  const std::string xml =
      DomainXml(cluster, 1, Role::kActor, 0, Plane::kExperience, {.address = "10.0.0.2", .mtu = 1400});
  EXPECT_THAT(xml, HasSubstr("<MaxMessageSize>1372 B</MaxMessageSize><MaxRexmitMessageSize>1372 B<"));
  EXPECT_THAT(xml, HasSubstr("<FragmentSize>1212 B"));
}

TEST(FindFreePort, GivesEachCallerItsOwnBlock) {
  std::set<int> bases;
  for (int i = 0; i < 5; ++i) {
    const auto base = FindFreePort();
    ASSERT_TRUE(base) << base.error().message;
    EXPECT_GE(*base, 1024);
    EXPECT_LE(*base + kPortBlock, 32768);
    EXPECT_TRUE(bases.insert(*base).second);
  }
}

TEST(FindFreePort, SkipsABlockInWhichAnyPortIsTaken) {
  UdpSocket taken;
  const int base = FindFreePort().value();
  ASSERT_TRUE(taken.Bind(base + 117));
  EXPECT_FALSE(IsUdpPortFree(base + 117));
  for (int i = 0; i < 5; ++i) EXPECT_NE(FindFreePort().value(), base);
}

TEST(Node, NamesThePortThatIsTaken) {
  const ClusterConfig cluster = LoopbackCluster();
  const auto first = MakeNode(cluster, Role::kLearner);
  const auto second = Node::Create(cluster, 1, Role::kLearner, 0);
  ASSERT_FALSE(second);
  EXPECT_EQ(second.error().code, ErrorCode::kUnavailable);
  EXPECT_THAT(second.error().message, HasSubstr(std::to_string(cluster.port + kPlanePorts + 12)));
  EXPECT_THAT(second.error().message, HasSubstr("cluster.port"));
}

TEST(Node, GivesItsPortsBackWhenItGoes) {
  const ClusterConfig cluster = LoopbackCluster();
  for (int i = 0; i < 3; ++i) EXPECT_NE(MakeNode(cluster, Role::kReplay), nullptr);
}

TEST(Node, RefusesAHostThatIsNotHere) {
  ClusterConfig cluster = LoopbackCluster();
  cluster.host = "203.0.113.1";
  const auto learner = Node::Create(cluster, 1, Role::kLearner, 0);
  ASSERT_FALSE(learner);
  EXPECT_EQ(learner.error().code, ErrorCode::kInvalidArgument);
  EXPECT_THAT(learner.error().message, HasSubstr("203.0.113.1"));
}

// What `ss` shows of this process: the local address of each of its UDP sockets.
std::set<std::string> BoundAddresses() {
  std::set<std::string> addresses;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    sockaddr_in name{};
    socklen_t length = sizeof(name);
    const int fd = std::stoi(entry.path().filename());
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&name), &length) != 0) continue;
    if (name.sin_family != AF_INET) continue;
    addresses.insert(fmt::format("{:08x}", ntohl(name.sin_addr.s_addr)));
  }
  return addresses;
}

TEST(Node, BindsEverySocketToItsOneAddress) {
  const ClusterConfig cluster = LoopbackCluster();
  const auto replay = MakeNode(cluster, Role::kReplay);
  const auto learner = MakeNode(cluster, Role::kLearner);
  const auto actor = MakeNode(cluster, Role::kActor);
  EXPECT_EQ(BoundAddresses(), std::set<std::string>{"7f000001"});
}

TEST(Node, FindsOnlyThoseWithTheSameKey) {
  const ClusterConfig cluster = LoopbackCluster();
  const std::string key(32, '1');
  const auto replay = Node::Create(cluster, 1, Role::kReplay, 0, key).value();
  const auto reader = BlobReader::Create(*replay, kNewest).value();
  const auto stranger = Node::Create(cluster, 1, Role::kActor, 0, std::string(32, '2')).value();
  const auto plain = Node::Create(cluster, 1, Role::kActor, 0).value();
  std::vector<std::unique_ptr<BlobWriter>> others;
  for (const auto* node : {&stranger, &plain}) others.push_back(BlobWriter::Create(**node, kNewest).value());
  // They came first: when the last one is known, they would be.
  const auto friendly = Node::Create(cluster, 1, Role::kActor, 0, key).value();
  const auto writer = BlobWriter::Create(*friendly, kNewest).value();
  EXPECT_TRUE(Eventually([&] { return writer->matched() == 1 && reader->matched() == 1; }));
  for (const auto& other : others) EXPECT_EQ(other->matched(), 0);
}

// Cyclone's own way out waits for ever for a packet to the address that is gone.
TEST(Node, NoticesThatItsAddressIsGoneAndEndsAllTheSame) {
  if (!MayMakeNamespaces()) GTEST_SKIP() << "only root may make network namespaces";
  const NetworkNamespace here('a');
  const NetworkNamespace there('b');
  Connect(here, "10.213.79.1", there, "10.213.79.2");
  here.Run([&] {
    ClusterConfig cluster = LoopbackCluster();
    cluster.host = "10.213.79.2";
    const auto actor = MakeNode(cluster, Role::kActor);
    ASSERT_TRUE(actor);
    EXPECT_TRUE(actor->CheckAddress());
    Ip(fmt::format("-n {} addr del 10.213.79.1/24 dev {}", here.name(), here.device()));
    EXPECT_TRUE(actor->CheckAddress()) << "there is no other yet";
    Ip(fmt::format("-n {} addr add 10.213.79.7/24 dev {}", here.name(), here.device()));
    const Status moved = actor->CheckAddress();
    ASSERT_FALSE(moved);
    EXPECT_THAT(moved.error().message, HasSubstr("was 10.213.79.1 and is 10.213.79.7 now"));
  });
}

TEST(Node, AnActorWithoutANetworkWaitsForOne) {
  if (!MayMakeNamespaces()) GTEST_SKIP() << "only root may make network namespaces";
  const NetworkNamespace here('a');
  const NetworkNamespace there('b');
  here.Run([&] {
    ClusterConfig cluster = LoopbackCluster();
    cluster.host = "10.213.79.2";
    EXPECT_EQ(Node::Create(cluster, 1, Role::kMonitor, 0).error().code, ErrorCode::kUnavailable);
    const auto actor = MakeNode(cluster, Role::kActor);
    ASSERT_TRUE(actor);
    EXPECT_TRUE(actor->CheckAddress());
    Connect(here, "10.213.79.1", there, "10.213.79.2");
    EXPECT_FALSE(actor->CheckAddress());
  });
}

TEST(Node, AsksForAKeyThatIsRequired) {
  ClusterConfig cluster = LoopbackCluster();
  cluster.require_key = true;
  const auto actor = Node::Create(cluster, 1, Role::kActor, 0);
  ASSERT_FALSE(actor);
  EXPECT_THAT(actor.error().message, HasSubstr("cluster.require_key"));
}

TEST(Node, RefusesAHostWithoutAddress) {
  ClusterConfig cluster = LoopbackCluster();
  cluster.host = "no host";
  const auto actor = Node::Create(cluster, 1, Role::kActor, 0);
  ASSERT_FALSE(actor);
  EXPECT_EQ(actor.error().code, ErrorCode::kInvalidArgument);
}

TEST(Node, RefusesPortsThatDoNotExist) {
  ClusterConfig cluster;
  EXPECT_EQ(Node::Create(cluster, 1, Role::kActor, 0).error().code, ErrorCode::kInvalidArgument);
  cluster.port = 65500;
  EXPECT_EQ(Node::Create(cluster, 1, Role::kActor, 0).error().code, ErrorCode::kInvalidArgument);
  cluster = LoopbackCluster();
  EXPECT_EQ(Node::Create(cluster, 1, Role::kReplay, 1).error().code, ErrorCode::kInvalidArgument);
}

TEST(Node, IsNotBrokenByCycloneddsUri) {
  ::setenv("CYCLONEDDS_URI", "<CycloneDDS><Domain><NoSuchElement/></Domain></CycloneDDS>", 1);
  const ClusterConfig cluster = LoopbackCluster();
  const auto replay = MakeNode(cluster, Role::kReplay);
  const auto actor = MakeNode(cluster, Role::kActor);
  ::unsetenv("CYCLONEDDS_URI");
  ASSERT_TRUE(replay && actor);
  const auto reader = BlobReader::Create(*replay, kStream).value();
  const auto writer = BlobWriter::Create(*actor, kStream).value();
  EXPECT_TRUE(Eventually([&] { return writer->matched() == 1; }));
}

TEST(Node, LeavesNoTraceFileBehind) {
  const auto before = std::filesystem::current_path();
  const TemporaryFolder folder;
  std::filesystem::current_path(folder.path());
  MakeNode(LoopbackCluster(), Role::kReplay);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  std::filesystem::current_path(before);
}

TEST(Node, TakesASmallerReceiveBufferThanItAskedFor) {
  ClusterConfig cluster = LoopbackCluster();
  cluster.receive_buffer_bytes = int64_t{1} << 30;
  ASSERT_LT(GrantedReceiveBuffer(cluster.receive_buffer_bytes), cluster.receive_buffer_bytes);
  EXPECT_NE(MakeNode(cluster, Role::kReplay), nullptr);
}

}  // namespace
}  // namespace dadrl::dds
