#include "learner/weight_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>

#include "common/io/checksum.h"
#include "common/port/memory_transport.h"
#include "tests/common/io/temporary_folder.h"

namespace dadrl {
namespace {

using namespace std::chrono_literals;

struct Received {
  uint32_t version = 0;
  int64_t published_ns = 0;
  uint64_t layout_hash = 0;
  uint64_t checksum = 0;
  std::vector<std::byte> bytes;
};

class WeightPublisherTest : public testing::Test {
 protected:
  std::unique_ptr<WeightPublisher> MakePublisher() {
    VersionReserve reserve = VersionReserve::Open(folder_.path()).value();
    const uint32_t newest = reserve.highest();
    return WeightPublisher::Create(transport_, std::move(reserve), newest, clock_).value();
  }
  void Publish(WeightPublisher& publisher, uint32_t version) {
    std::vector<float> parameters(300000, static_cast<float>(version));
    publisher.Publish({.version = version, .layout_hash = 42, .parameters = parameters});
  }
  // What the actor has not taken yet: the newest, if there is one.
  static std::optional<Received> Take(Reader<dadrl_idl_Weights>& reader) {
    std::optional<Received> found;
    reader.Take(10, [&](const dadrl_idl_Weights& weights) {
      const auto bytes = std::as_bytes(std::span(weights.parameters._buffer, weights.parameters._length));
      found = Received{weights.version, weights.published_ns, weights.layout_hash, weights.checksum,
                       std::vector<std::byte>(bytes.begin(), bytes.end())};
    });
    return found;
  }
  std::unique_ptr<Reader<dadrl_idl_Weights>> MakeActor() const {
    return Reader<dadrl_idl_Weights>::Create(transport_, kWeightsTopic).value();
  }

  TemporaryFolder folder_;
  ManualClock clock_;
  const MemoryTransport transport_;
};

TEST_F(WeightPublisherTest, ALateActorGetsTheNewestPolicyWhole) {
  const auto publisher = MakePublisher();
  for (uint32_t version = 1; version <= 2; ++version) {
    Publish(*publisher, version);
    clock_.Advance(3s);
    publisher->Step();
  }
  EXPECT_EQ(publisher->newest_version(), 2u);
  const auto received = Take(*MakeActor());
  ASSERT_TRUE(received);
  EXPECT_EQ(received->version, 2u);
  EXPECT_EQ(received->published_ns, 6'000'000'000);
  EXPECT_EQ(received->layout_hash, 42u);
  EXPECT_EQ(received->bytes.size(), 300000 * sizeof(float));
  EXPECT_EQ(received->checksum, Xxh3(received->bytes));
  EXPECT_EQ(reinterpret_cast<const float*>(received->bytes.data())[299999], 2.0f);
}

TEST_F(WeightPublisherTest, VersionsOnTheWireGrowOverARestartWithoutACheckpoint) {
  const auto actor = MakeActor();
  uint32_t last = 0;
  for (int restart = 0; restart < 3; ++restart) {
    const auto publisher = MakePublisher();
    for (uint32_t i = 0; i < 3; ++i) {
      Publish(*publisher, publisher->newest_version() + 1);
      publisher->Step();
      const auto received = Take(*actor);
      ASSERT_TRUE(received);
      EXPECT_GT(received->version, last);
      last = received->version;
    }
  }
}

TEST_F(WeightPublisherTest, APolicyThatIsOvertakenStaysAndTheLastLeavesBeforeTheEnd) {
  const auto actor = MakeActor();
  auto publisher = MakePublisher();
  for (uint32_t version = 1; version <= 50; ++version) Publish(*publisher, version);
  publisher->Step();
  EXPECT_EQ(Take(*actor)->version, 50u);
  publisher->Step();
  EXPECT_FALSE(Take(*actor)) << "it is sent once";
  Publish(*publisher, 51);
  publisher.reset();
  EXPECT_EQ(Take(*actor)->version, 51u);
}

TEST_F(WeightPublisherTest, StartedItSendsByItself) {
  const auto actor = MakeActor();
  const auto publisher = MakePublisher();
  publisher->Start();
  Publish(*publisher, 1);
  EXPECT_TRUE(actor->Wait(30s));
}

}  // namespace
}  // namespace dadrl
