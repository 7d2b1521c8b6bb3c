// The oracle itself, against the definition of a derivative.
#include "common/nn/kernels/conv_reference.h"

#include <gtest/gtest.h>

#include "tests/common/nn/kernels/conv_fixture.h"

namespace dadrl::nn::testing {
namespace {

// sum(d_features * features) of one image.
double Loss(const std::vector<uint8_t>& context, const Tensors<double>& params,
            const std::vector<float>& d_features) {
  static const auto image = std::make_unique<reference::Image<double>>();
  static const auto out = std::make_unique<reference::Outputs<double>>();
  reference::Forward(context.data(), params.reference_params(), *image, *out);
  double loss = 0;
  for (size_t i = 0; i < kConvFeatures; ++i) loss += static_cast<double>(d_features[i]) * out->layer5[i];
  return loss;
}

TEST(ConvReferenceTest, GradientsMatchFiniteDifferences) {
  const auto context = RandomImages(2, 51);
  const std::vector<uint8_t> image(context.begin() + kContextImageBytes, context.end());
  Tensors<double> params = ToDouble(RandomParams(52));
  const auto d_features = RandomFloats(kConvFeatures, 53);
  const Oracle oracle(image, params, d_features);
  constexpr double kStep = 1e-7;
  std::mt19937 random(54);
  const auto check = [&](std::vector<double>& values, const std::vector<double>& gradient) {
    double scale = 0;
    for (double g : gradient) scale = std::max(scale, std::abs(g));
    ASSERT_GT(scale, 0);
    for (int trial = 0; trial < 8; ++trial) {
      const size_t i = random() % values.size();
      const double before = values[i];
      values[i] = before + kStep;
      const double above = Loss(image, params, d_features);
      values[i] = before - kStep;
      const double below = Loss(image, params, d_features);
      values[i] = before;
      EXPECT_NEAR((above - below) / (2 * kStep), gradient[i], 1e-5 * scale) << "element " << i;
    }
  };
  for (int l = 0; l < kConvLayers; ++l) {
    check(params.weight[l], oracle.grads.weight[l]);
    check(params.bias[l], oracle.grads.bias[l]);
  }
}

}  // namespace
}  // namespace dadrl::nn::testing
