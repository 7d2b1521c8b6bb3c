// Every instruction set of this processor against the stack in double precision.
#include "common/nn/kernels/conv_stack.h"

#include <gtest/gtest.h>

#include <string>
#include <thread>

#include "tests/common/nn/kernels/conv_fixture.h"

namespace dadrl::nn::testing {
namespace {

constexpr double kTolerance = 1e-5;

class ConvStackTest : public ::testing::TestWithParam<Isa> {
 protected:
  IsaScope scope_{GetParam()};
};

void ExpectMatchesOracle(const std::vector<uint8_t>& context, unsigned seed) {
  const Tensors<float> params = RandomParams(seed);
  const auto d_features = RandomFloats(context.size() / kContextImageBytes * kConvFeatures, seed + 1);
  const Oracle expected(context, ToDouble(params), d_features);
  const StepResult actual(context, params, d_features);
  EXPECT_LE(MaxNormError(actual.features, expected.features), kTolerance);
  for (int l = 0; l < kConvLayers; ++l) {
    EXPECT_LE(MaxNormError(actual.grads.weight[l], expected.grads.weight[l]), kTolerance)
        << "weight " << l + 1;
    EXPECT_LE(MaxNormError(actual.grads.bias[l], expected.grads.bias[l]), kTolerance) << "bias " << l + 1;
  }
}

TEST_P(ConvStackTest, MatchesOracleOnOneGroup) { ExpectMatchesOracle(RandomImages(16, 1), 11); }
TEST_P(ConvStackTest, MatchesOracleOnTwoGroups) { ExpectMatchesOracle(RandomImages(32, 2), 12); }
TEST_P(ConvStackTest, MatchesOracleOnThreeGroups) { ExpectMatchesOracle(RandomImages(48, 3), 13); }
TEST_P(ConvStackTest, MatchesOracleOnRoads) { ExpectMatchesOracle(RoadImages(32), 14); }
TEST_P(ConvStackTest, MatchesOracleOnEmptyImages) {
  ExpectMatchesOracle(std::vector<uint8_t>(16 * kContextImageBytes, 0x00), 15);
}
TEST_P(ConvStackTest, MatchesOracleOnFullImages) {
  ExpectMatchesOracle(std::vector<uint8_t>(16 * kContextImageBytes, 0xFF), 16);
}

// Shows which pixel each bit is: a wrong order would still pass tests whose oracle shares the mistake.
TEST_P(ConvStackTest, ReadsPixelsInObservationOrder) {
  Tensors<float> params;
  params.weight[0][(1 * 2 + 1) * 25 + 3 * 5 + 2] = 1;  // channel 1 sees plane 1, kernel row 3, column 2
  params.weight[1][(0 * 4 + 1) * 25 + 2 * 5 + 4] = 1;
  params.weight[2][(0 * 8 + 0) * 25 + 1 * 5 + 0] = 1;
  params.weight[3][(0 * 16 + 0) * 25 + 4 * 5 + 3] = 1;
  params.weight[4][(5 * 32 + 0) * 9 + 2 * 3 + 1] = 1;
  // Back from feature (channel 5, row 1, column 0): layer 5 input, 4, 3, 2, and the image.
  const int row5 = 2 * 1 + 2, column5 = 2 * 0 + 1;
  const int row4 = 2 * row5 + 4, column4 = 2 * column5 + 3;
  const int row3 = 2 * row4 + 1, column3 = 2 * column4 + 0;
  const int row2 = 2 * row3 + 2, column2 = 2 * column3 + 4;
  const int row1 = 2 * row2 + 3, column1 = 2 * column2 + 2;
  std::vector<uint8_t> context(16 * kContextImageBytes, 0);
  context[static_cast<size_t>(7 * kContextImageBytes + (128 + row1) * 16 + column1 / 8)] =
      static_cast<uint8_t>(1U << (column1 % 8));
  const StepResult run(context, params, std::vector<float>(16 * kConvFeatures, 1.0F));
  for (size_t i = 0; i < run.features.size(); ++i) {
    EXPECT_EQ(run.features[i], i == 7 * kConvFeatures + 5 * 4 + 1 * 2 + 0 ? 1.0F : 0.0F) << i;
  }
}

TEST_P(ConvStackTest, GivesTheSameFeaturesWithoutKeepingActivations) {
  const auto context = RandomImages(32, 4);
  const Tensors<float> params = RandomParams(17);
  const StepResult kept(context, params, RandomFloats(32 * kConvFeatures, 18));
  Arena arena(ConvStackActivationBytes(32, false));
  std::vector<float> features(32 * kConvFeatures);
  ConvStackForward(context.data(), 32, params.params(), arena.get(), features.data(), false);
  EXPECT_EQ(ToRows(features), kept.features);
}

TEST_P(ConvStackTest, RepeatedBackwardOverwritesGradients) {
  const auto context = RandomImages(16, 5);
  const Tensors<float> params = RandomParams(19);
  const auto d_features = RandomFloats(16 * kConvFeatures, 20);
  Arena arena(ConvStackActivationBytes(16, true));
  std::vector<float> features(16 * kConvFeatures);
  ConvStackForward(context.data(), 16, params.params(), arena.get(), features.data(), true);
  Tensors<float> first, second;
  ConvStackBackward(context.data(), 16, params.params(), arena.get(), d_features.data(), first.grads());
  ConvStackBackward(context.data(), 16, params.params(), arena.get(), d_features.data(), second.grads());
  for (int l = 0; l < kConvLayers; ++l) {
    EXPECT_EQ(first.weight[l], second.weight[l]);
    EXPECT_EQ(first.bias[l], second.bias[l]);
  }
}

TEST_P(ConvStackTest, ThreadsDoNotDisturbEachOther) {
  const auto context = RandomImages(16, 6), other = RandomImages(16, 7);
  const Tensors<float> params = RandomParams(21);
  const auto d_features = RandomFloats(16 * kConvFeatures, 22);
  const StepResult alone(context, params, d_features);
  std::thread neighbour([&] { StepResult(other, params, d_features); });
  const StepResult together(context, params, d_features);
  neighbour.join();
  EXPECT_EQ(alone.features, together.features);
  for (int l = 0; l < kConvLayers; ++l) EXPECT_EQ(alone.grads.weight[l], together.grads.weight[l]);
}

TEST_P(ConvStackTest, SingleImageAgreesWithBatch) {
  const Tensors<float> params = RandomParams(23);
  auto context = RandomImages(14, 8);
  context.insert(context.end(), kContextImageBytes, 0x00);
  context.insert(context.end(), kContextImageBytes, 0xFF);
  const StepResult batch(context, params, std::vector<float>(16 * kConvFeatures));
  SingleImageConvStack single;
  single.Pack(params.params());
  std::vector<float> features(16 * kConvFeatures);
  for (size_t n = 0; n < 16; ++n) {
    single.Forward(context.data() + n * kContextImageBytes, features.data() + n * kConvFeatures);
  }
  EXPECT_LE(MaxNormError(features, batch.features), kTolerance);
}

TEST_P(ConvStackTest, SingleImageFollowsRepacking) {
  const auto context = RandomImages(1, 9);
  SingleImageConvStack single, fresh;
  std::vector<float> unpacked(kConvFeatures, 1.0F), repacked(kConvFeatures), expected(kConvFeatures);
  single.Forward(context.data(), unpacked.data());
  EXPECT_EQ(unpacked, std::vector<float>(kConvFeatures, 0.0F));
  single.Pack(RandomParams(24).params());
  single.Pack(RandomParams(25).params());
  fresh.Pack(RandomParams(25).params());
  single.Forward(context.data(), repacked.data());
  fresh.Forward(context.data(), expected.data());
  EXPECT_EQ(repacked, expected);
}

TEST_P(ConvStackTest, EmptyBatchHasZeroGradients) {
  const Tensors<float> params = RandomParams(26);
  Arena arena(ConvStackActivationBytes(0, true));
  Tensors<float> grads;
  for (auto& weight : grads.weight) std::fill(weight.begin(), weight.end(), 1.0F);
  ConvStackForward(nullptr, 0, params.params(), arena.get(), nullptr, true);
  ConvStackBackward(nullptr, 0, params.params(), arena.get(), nullptr, grads.grads());
  for (const auto& weight : grads.weight) {
    EXPECT_TRUE(std::all_of(weight.begin(), weight.end(), [](float w) { return w == 0.0F; }));
  }
}

INSTANTIATE_TEST_SUITE_P(Isas, ConvStackTest, ::testing::ValuesIn(AvailableIsas()),
                         [](const auto& test) { return std::string(IsaName(test.param)); });

}  // namespace
}  // namespace dadrl::nn::testing
