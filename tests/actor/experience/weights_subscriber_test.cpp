#include "actor/experience/weights_subscriber.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>

#include "common/io/checksum.h"
#include "common/port/memory_transport.h"

namespace dadrl {
namespace {

constexpr size_t kParameters = 100000;
constexpr uint64_t kLayout = 0x1234;

class WeightsSubscriberTest : public ::testing::Test {
 protected:
  WeightsSubscriberTest() {
    writer_ = Writer<dadrl_idl_Weights>::Create(transport_, kWeightsTopic).value();
    subscriber_ = WeightsSubscriber::Create(transport_, kParameters, kLayout).value();
  }

  // A good message of `version`; change it, then Publish.
  dadrl_idl_Weights Make(uint32_t version) {
    parameters_.assign(kParameters, static_cast<float>(version));
    dadrl_idl_Weights weights{};
    weights.version = version;
    weights.published_ns = 1000 + version;
    weights.layout_hash = kLayout;
    weights.checksum = Xxh3(std::as_bytes(std::span(parameters_)));
    weights.parameters._buffer = reinterpret_cast<uint8_t*>(parameters_.data());
    weights.parameters._length = weights.parameters._maximum = kParameters * sizeof(float);
    return weights;
  }
  void ExpectRefused(const dadrl_idl_Weights& weights) {
    const uint64_t before = subscriber_->refused();
    ASSERT_TRUE(writer_->Write(weights));
    std::vector<float> parameters;
    EXPECT_EQ(subscriber_->TakeNewer(0, parameters), 0);
    EXPECT_EQ(subscriber_->refused(), before + 1);
    EXPECT_TRUE(parameters.empty());
  }

  const MemoryTransport transport_;
  std::vector<float> parameters_;
  std::unique_ptr<Writer<dadrl_idl_Weights>> writer_;
  std::unique_ptr<WeightsSubscriber> subscriber_;
};

TEST_F(WeightsSubscriberTest, GivesTheNewestOnce) {
  std::vector<float> parameters;
  EXPECT_EQ(subscriber_->TakeNewer(0, parameters), 0);
  ASSERT_TRUE(writer_->Write(Make(1)));
  EXPECT_EQ(subscriber_->TakeNewer(0, parameters), 1);
  EXPECT_EQ(parameters, parameters_);
  EXPECT_EQ(subscriber_->published_ns(), 1001);
  EXPECT_EQ(subscriber_->TakeNewer(1, parameters), 0);
  for (uint32_t version = 2; version <= 5; ++version) ASSERT_TRUE(writer_->Write(Make(version)));
  EXPECT_EQ(subscriber_->TakeNewer(1, parameters), 5);
  EXPECT_EQ(parameters, parameters_);
  EXPECT_EQ(subscriber_->refused(), 0);
}

TEST_F(WeightsSubscriberTest, IgnoresAnOlderVersionThanItHas) {
  std::vector<float> parameters;
  ASSERT_TRUE(writer_->Write(Make(7)));
  ASSERT_EQ(subscriber_->TakeNewer(0, parameters), 7);
  ASSERT_TRUE(writer_->Write(Make(6)));
  ASSERT_TRUE(writer_->Write(Make(8)));
  EXPECT_EQ(subscriber_->TakeNewer(7, parameters), 8);
}

TEST_F(WeightsSubscriberTest, RefusesDamagedParameters) {
  dadrl_idl_Weights weights = Make(1);
  parameters_[kParameters / 2] += 1.0f;
  ExpectRefused(weights);
}

TEST_F(WeightsSubscriberTest, RefusesAnotherNetwork) {
  dadrl_idl_Weights weights = Make(1);
  weights.layout_hash = kLayout + 1;
  ExpectRefused(weights);
  EXPECT_EQ(subscriber_->refused_layouts(), 1);
}

TEST_F(WeightsSubscriberTest, RefusesAWrongLength) {
  for (const size_t length : {size_t{0}, size_t{4}, kParameters * sizeof(float) - 1}) {
    dadrl_idl_Weights weights = Make(1);
    weights.parameters._length = static_cast<uint32_t>(length);
    weights.checksum = Xxh3(std::as_bytes(std::span(parameters_)).first(length));
    ExpectRefused(weights);
  }
  EXPECT_EQ(subscriber_->refused_layouts(), 0);
}

TEST_F(WeightsSubscriberTest, RefusesParametersThatNoNetworkHas) {
  for (const float parameter : {std::nanf(""), std::numeric_limits<float>::infinity(), 3e38f, -10001.0f}) {
    dadrl_idl_Weights weights = Make(1);
    parameters_.back() = parameter;
    weights.checksum = Xxh3(std::as_bytes(std::span(parameters_)));
    ExpectRefused(weights);
  }
}

TEST_F(WeightsSubscriberTest, RefusesVersionZero) { ExpectRefused(Make(0)); }

TEST_F(WeightsSubscriberTest, KeepsItsPolicyWhenTheNextIsDamaged) {
  std::vector<float> parameters;
  ASSERT_TRUE(writer_->Write(Make(1)));
  ASSERT_EQ(subscriber_->TakeNewer(0, parameters), 1);
  const std::vector<float> good = parameters;
  dadrl_idl_Weights weights = Make(2);
  weights.checksum ^= 1;
  ASSERT_TRUE(writer_->Write(weights));
  EXPECT_EQ(subscriber_->TakeNewer(1, parameters), 0);
  EXPECT_EQ(subscriber_->refused(), 1);
  EXPECT_EQ(parameters, good);
  EXPECT_EQ(subscriber_->published_ns(), 1001);
}

}  // namespace
}  // namespace dadrl
