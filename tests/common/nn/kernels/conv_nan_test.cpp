// A NaN must reach whoever checks the outputs: kernels that skip empty pixels or take maxima easily lose it.
#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "tests/common/nn/kernels/conv_fixture.h"

namespace dadrl::nn::testing {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

class ConvNanTest : public ::testing::TestWithParam<Isa> {
 protected:
  static bool HasNan(const std::vector<float>& values) {
    return std::any_of(values.begin(), values.end(), [](float v) { return std::isnan(v); });
  }

  IsaScope scope_{GetParam()};
};

TEST_P(ConvNanTest, WeightSurfacesInFeatures) {
  const auto context = RoadImages(16);
  for (int l = 0; l < kConvLayers; ++l) {
    Tensors<float> params = RandomParams(31);
    params.weight[l][params.weight[l].size() - 3] = kNan;
    const StepResult run(context, params, std::vector<float>(16 * kConvFeatures));
    for (size_t n = 0; n < 16; ++n) {
      const auto image = run.features.begin() + static_cast<ptrdiff_t>(n * kConvFeatures);
      EXPECT_TRUE(HasNan({image, image + kConvFeatures})) << "layer " << l + 1 << ", image " << n;
    }
  }
}

TEST_P(ConvNanTest, FirstLayerWeightSurfacesEvenFromEmptyImages) {
  const std::vector<uint8_t> context(16 * kContextImageBytes, 0);
  Tensors<float> params = RandomParams(32);
  params.weight[0][7] = kNan;
  EXPECT_TRUE(HasNan(StepResult(context, params, std::vector<float>(16 * kConvFeatures)).features));
}

TEST_P(ConvNanTest, BiasSurfacesInFeatures) {
  const auto context = RandomImages(16, 33);
  for (int l = 0; l < kConvLayers; ++l) {
    Tensors<float> params = RandomParams(34);
    params.bias[l][0] = kNan;
    EXPECT_TRUE(HasNan(StepResult(context, params, std::vector<float>(16 * kConvFeatures)).features))
        << l + 1;
  }
}

TEST_P(ConvNanTest, WeightSurfacesInSingleImageFeatures) {
  const auto context = RoadImages(1);
  for (int l = 0; l < kConvLayers; ++l) {
    Tensors<float> params = RandomParams(35);
    params.weight[l][params.weight[l].size() - 3] = kNan;
    SingleImageConvStack single;
    single.Pack(params.params());
    std::vector<float> features(kConvFeatures);
    single.Forward(context.data(), features.data());
    EXPECT_TRUE(HasNan(features)) << "layer " << l + 1;
  }
}

TEST_P(ConvNanTest, GradientOfAnActiveFeatureSurfacesInAllLayers) {
  const auto context = RandomImages(16, 36);
  const Tensors<float> params = RandomParams(37);
  auto d_features = RandomFloats(16 * kConvFeatures, 38);
  const StepResult clean(context, params, d_features);
  const auto active =
      std::find_if(clean.features.begin(), clean.features.end(), [](float f) { return f > 0; });
  ASSERT_NE(active, clean.features.end());
  d_features[static_cast<size_t>(active - clean.features.begin())] = kNan;
  const StepResult run(context, params, d_features);
  for (int l = 0; l < kConvLayers; ++l) {
    EXPECT_FALSE(HasNan(clean.grads.weight[l]));
    EXPECT_TRUE(HasNan(run.grads.weight[l])) << "weight " << l + 1;
    EXPECT_TRUE(HasNan(run.grads.bias[l])) << "bias " << l + 1;
  }
}

// As PyTorch: the derivative of an inactive ReLU is zero whatever comes from above.
TEST_P(ConvNanTest, GradientOfAnInactiveFeatureIsDropped) {
  const auto context = RandomImages(16, 39);
  const Tensors<float> params = RandomParams(40);
  auto d_features = RandomFloats(16 * kConvFeatures, 41);
  const StepResult clean(context, params, d_features);
  const auto inactive = std::find(clean.features.begin(), clean.features.end(), 0.0F);
  ASSERT_NE(inactive, clean.features.end());
  d_features[static_cast<size_t>(inactive - clean.features.begin())] = kNan;
  const StepResult run(context, params, d_features);
  for (int l = 0; l < kConvLayers; ++l) EXPECT_EQ(run.grads.weight[l], clean.grads.weight[l]);
}

// Also as PyTorch: an output that is NaN is not inactive.
TEST_P(ConvNanTest, GradientPassesOutputsThatAreNan) {
  const auto context = RandomImages(16, 44);
  Tensors<float> params = RandomParams(45);
  params.bias[0][0] = kNan;
  const auto d_features = RandomFloats(16 * kConvFeatures, 46);
  const Oracle expected(context, ToDouble(params), d_features);
  const StepResult run(context, params, d_features);
  for (int l = 0; l < kConvLayers; ++l) {
    EXPECT_FALSE(HasNan(run.grads.bias[l]));
    EXPECT_LE(MaxNormError(run.grads.bias[l], expected.grads.bias[l]), 1e-5) << "bias " << l + 1;
  }
}

TEST_P(ConvNanTest, InfiniteWeightDoesNotLookFinite) {
  const auto context = RandomImages(16, 42);
  Tensors<float> params = RandomParams(43);
  params.weight[2][5] = std::numeric_limits<float>::infinity();
  const StepResult run(context, params, std::vector<float>(16 * kConvFeatures));
  EXPECT_TRUE(
      std::any_of(run.features.begin(), run.features.end(), [](float f) { return !std::isfinite(f); }));
}

INSTANTIATE_TEST_SUITE_P(Isas, ConvNanTest, ::testing::ValuesIn(AvailableIsas()),
                         [](const auto& test) { return std::string(IsaName(test.param)); });

}  // namespace
}  // namespace dadrl::nn::testing
