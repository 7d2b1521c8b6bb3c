#include "common/nn/squashed_gaussian.h"

#include <gtest/gtest.h>

namespace dadrl::nn {
namespace {

constexpr GaussianLimits kLimits{-5.0, 2.0};

TEST(SquashedGaussianTest, DensityIntegratesToOne) {
  // Over the action, by the noise that produces it: mean and spread such that nothing saturates.
  double total = 0.0;
  double previous = -1.0;
  for (int i = 0; i <= 40000; ++i) {
    const SquashedSample sample = SampleSquashed(0.3, -0.7, -8.0 + 16.0 * i / 40000, kLimits);
    total += std::exp(sample.log_probability) * (sample.action - previous);
    previous = sample.action;
  }
  EXPECT_NEAR(total, 1.0, 1e-3);
}

TEST(SquashedGaussianTest, StaysFiniteWhereTanhSaturates) {
  for (const double mean : {-50.0, 50.0}) {
    const SquashedSample sample = SampleSquashed(mean, 0.0, 0.5, kLimits);
    EXPECT_TRUE(std::isfinite(sample.log_probability));
    EXPECT_LE(std::abs(sample.action), 1.0);
  }
}

TEST(SquashedGaussianTest, GradientsAgreeWithFiniteDifferences) {
  constexpr double kStep = 1e-6;
  for (const double mean : {-1.5, 0.2}) {
    for (const double log_std : {-2.0, 0.5}) {
      for (const double noise : {-1.0, 0.7}) {
        // Any loss: 0.3 action - 0.8 log probability.
        const auto loss = [&](double m, double s) {
          const SquashedSample sample = SampleSquashed(m, s, noise, kLimits);
          return 0.3 * sample.action - 0.8 * sample.log_probability;
        };
        const SquashedGradient gradient =
            SquashedBackward(SampleSquashed(mean, log_std, noise, kLimits), noise, 0.3, -0.8);
        EXPECT_NEAR(gradient.mean, (loss(mean + kStep, log_std) - loss(mean - kStep, log_std)) / (2 * kStep),
                    1e-8);
        EXPECT_NEAR(gradient.log_std,
                    (loss(mean, log_std + kStep) - loss(mean, log_std - kStep)) / (2 * kStep), 1e-8);
      }
    }
  }
}

TEST(SquashedGaussianTest, DensityOfADrawIsThatOfTheDraw) {
  for (const double noise : {-2.0, 0.0, 1.5}) {
    const SquashedSample sample = SampleSquashed(0.4, -0.5, noise, kLimits);
    EXPECT_NEAR(DensityOf(sample.action, 0.4, -0.5, kLimits).log_probability, sample.log_probability, 1e-9);
  }
}

TEST(SquashedGaussianTest, GradientsOfADensityAgreeWithFiniteDifferences) {
  constexpr double kStep = 1e-6;
  for (const double action : {-0.9, 0.0, 0.3}) {
    for (const double mean : {-1.5, 0.2}) {
      for (const double log_std : {-1.0, 0.5}) {
        const auto density = [&](double m, double s) {
          return DensityOf(action, m, s, kLimits).log_probability;
        };
        const SquashedDensity exact = DensityOf(action, mean, log_std, kLimits);
        EXPECT_NEAR(exact.mean_gradient,
                    (density(mean + kStep, log_std) - density(mean - kStep, log_std)) / (2 * kStep), 1e-6);
        EXPECT_NEAR(exact.log_std_gradient,
                    (density(mean, log_std + kStep) - density(mean, log_std - kStep)) / (2 * kStep), 1e-6);
      }
    }
  }
  EXPECT_EQ(DensityOf(0.1, 0.0, 3.0, kLimits).log_std_gradient, 0.0) << "beyond the limits";
}

TEST(SquashedGaussianTest, DensityOfAnActionThatWasRoundedToItsBoundIsFinite) {
  for (const double action : {-1.0, 1.0}) {
    EXPECT_TRUE(std::isfinite(DensityOf(action, 0.0, 0.0, kLimits).log_probability));
  }
}

TEST(SquashedGaussianTest, NoGradientBeyondTheLimits) {
  const SquashedSample sample = SampleSquashed(0.0, 3.0, 0.5, kLimits);
  EXPECT_TRUE(sample.clamped);
  EXPECT_EQ(SquashedBackward(sample, 0.5, 1.0, 1.0).log_std, 0.0);
}

}  // namespace
}  // namespace dadrl::nn
