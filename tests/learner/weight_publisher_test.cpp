#include "learner/weight_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "common/io/checksum.h"
#include "tests/common/dds/dds_fixture.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;

struct Received {
  uint32_t version = 0;
  uint64_t updates = 0;
  uint64_t layout_hash = 0;
  uint64_t checksum = 0;
  std::vector<std::byte> bytes;
};

class WeightPublisherTest : public testing::Test {
 protected:
  std::unique_ptr<WeightPublisher> StartPublisher() {
    VersionReserve reserve = VersionReserve::Open(folder_.path()).value();
    const uint32_t newest = reserve.highest();
    return WeightPublisher::Create(*learner_, std::move(reserve), newest).value();
  }
  void Publish(WeightPublisher& publisher, uint32_t version) {
    std::vector<float> parameters(300000, static_cast<float>(version));
    publisher.Publish(
        {.version = version, .updates = version * 10, .layout_hash = 42, .parameters = parameters});
  }
  // Takes until version `version` has come; the versions seen on the way are appended to `versions_`.
  std::optional<Received> Await(dds::Reader<dadrl_idl_Weights>& reader, uint32_t version) {
    std::optional<Received> found;
    Eventually([&] {
      reader.Wait(50ms);
      reader.Take(10, [&](const dadrl_idl_Weights& weights) {
        versions_.push_back(weights.version);
        const auto bytes = std::as_bytes(std::span(weights.parameters._buffer, weights.parameters._length));
        if (weights.version == version) {
          found = Received{weights.version, weights.updates, weights.layout_hash, weights.checksum,
                           std::vector<std::byte>(bytes.begin(), bytes.end())};
        }
      });
      return found.has_value();
    });
    return found;
  }

  TemporaryFolder folder_;
  const ClusterConfig cluster_ = dds::LoopbackCluster();
  std::unique_ptr<dds::Node> learner_ = dds::MakeNode(cluster_, dds::Role::kLearner);
  std::unique_ptr<dds::Node> actor_ = dds::MakeNode(cluster_, dds::Role::kActor);
  std::vector<uint32_t> versions_;
};

TEST_F(WeightPublisherTest, ALateActorGetsTheNewestPolicyWhole) {
  const auto publisher = StartPublisher();
  Publish(*publisher, 1);
  Publish(*publisher, 2);
  ASSERT_TRUE(Eventually([&] { return publisher->sent() >= 1 && publisher->newest_version() == 2; }));
  const auto reader = dds::Reader<dadrl_idl_Weights>::Create(*actor_, kWeightsTopic).value();
  const auto received = Await(*reader, 2);
  ASSERT_TRUE(received);
  EXPECT_EQ(received->updates, 20u);
  EXPECT_EQ(received->layout_hash, 42u);
  EXPECT_EQ(received->bytes.size(), 300000 * sizeof(float));
  EXPECT_EQ(received->checksum, Xxh3(received->bytes));
  EXPECT_EQ(reinterpret_cast<const float*>(received->bytes.data())[299999], 2.0f);
}

TEST_F(WeightPublisherTest, VersionsOnTheWireGrowOverARestartWithoutACheckpoint) {
  const auto reader = dds::Reader<dadrl_idl_Weights>::Create(*actor_, kWeightsTopic).value();
  uint32_t last = 0;
  for (int restart = 0; restart < 3; ++restart) {
    const auto publisher = StartPublisher();
    for (uint32_t i = 0; i < 3; ++i) {
      last = publisher->newest_version() + 1;
      Publish(*publisher, last);
    }
    ASSERT_TRUE(Await(*reader, last));
  }
  for (size_t i = 1; i < versions_.size(); ++i) EXPECT_GT(versions_[i], versions_[i - 1]);
}

TEST_F(WeightPublisherTest, PublishDoesNotWaitForActorsAndTheLastPolicyLeavesBeforeTheEnd) {
  const auto reader = dds::Reader<dadrl_idl_Weights>::Create(*actor_, kWeightsTopic).value();
  auto publisher = StartPublisher();
  Publish(*publisher, 1);
  ASSERT_TRUE(Await(*reader, 1));
  // The reader takes nothing meanwhile; each policy may be overtaken by the next, the last one may not.
  for (uint32_t version = 2; version <= 50; ++version) Publish(*publisher, version);
  std::thread closing([&] { publisher.reset(); });
  EXPECT_TRUE(Await(*reader, 50));
  closing.join();
}

}  // namespace
}  // namespace dadrl
