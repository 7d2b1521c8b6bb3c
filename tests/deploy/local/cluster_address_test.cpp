#include "deploy/local/cluster_address.h"

#include <gmock/gmock.h>

namespace dadrl {
namespace {

using testing::HasSubstr;

const std::vector<dds::LocalAddress> kLocal = {{"lo", "127.0.0.1"}, {"eth0", "192.0.2.2"}};

TEST(ClusterAddress, MayBeThisMachineAloneOrOneOfItsAddresses) {
  EXPECT_TRUE(CheckClusterAddress("127.0.0.1", "127.0.0.1", kLocal));
  EXPECT_TRUE(CheckClusterAddress("localhost", "127.0.0.1", kLocal));
  EXPECT_TRUE(CheckClusterAddress("192.0.2.2", "192.0.2.2", kLocal));
  EXPECT_TRUE(CheckClusterAddress("node7", "192.0.2.2", kLocal));
}

TEST(ClusterAddress, OfAnotherMachineIsRefusedWithWhatThereIs) {
  const Status refused = CheckClusterAddress("node8", "203.0.113.7", kLocal);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidArgument);
  EXPECT_EQ(refused.error().message,
            "cluster.host: node8 (203.0.113.7 here) is no address of this machine, where the replay and the "
            "learner run; it has 192.0.2.2 (eth0), 127.0.0.1 (this machine alone)");
}

// Debian maps a machine's own name so; nobody else reaches what listens there.
TEST(ClusterAddress, OfANameThatLeadsToLoopbackIsRefused) {
  for (const char* address : {"127.0.1.1", "127.0.0.1"}) {
    const Status refused = CheckClusterAddress("node7", address, kLocal);
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message, HasSubstr(fmt::format("node7 ({} here)", address)));
    EXPECT_THAT(refused.error().message, HasSubstr("no other machine reaches"));
    EXPECT_THAT(refused.error().message, HasSubstr("192.0.2.2 (eth0)"));
  }
  EXPECT_FALSE(CheckClusterAddress("127.0.1.1", "127.0.1.1", kLocal));
}

TEST(ClusterAddress, IsResolved) {
  EXPECT_EQ(ClusterAddress("localhost").value(), "127.0.0.1");
  EXPECT_THAT(ClusterAddress("no host").error().message, HasSubstr("'no host'"));
}

}  // namespace
}  // namespace dadrl
