// The policy's distribution: a Gaussian pushed through tanh (Haarnoja et al. 2018, appendix C), one sample at
// a time.
#pragma once

#include <algorithm>
#include <cmath>

namespace dadrl::nn {

struct GaussianLimits {
  double log_std_min = -5.0;
  double log_std_max = 2.0;
};

constexpr double kHalfLogTwoPi = 0.91893853320467274178;

// log(1 - tanh(u)^2) = 2 (log 2 - u - softplus(-2u)), which does not cancel for large |u|.
inline double LogTanhSlope(double u) {
  constexpr double kLogTwo = 0.69314718055994530942;
  const double softplus = std::max(-2.0 * u, 0.0) + std::log1p(std::exp(-std::abs(2.0 * u)));
  return 2.0 * (kLogTwo - u - softplus);
}

// One action dimension, reparametrised by `noise` (standard normal).
struct SquashedSample {
  double action = 0.0;           // tanh(mean + std * noise)
  double log_probability = 0.0;  // of the action, this dimension's share
  double std = 1.0;
  bool clamped = false;  // log_std was outside its limits, so no gradient reaches it
};

inline SquashedSample SampleSquashed(double mean, double log_std, double noise,
                                     const GaussianLimits& limits) {
  // A NaN passes through std::clamp and so reaches the loss, where it is reported.
  const double bounded = std::clamp(log_std, limits.log_std_min, limits.log_std_max);
  SquashedSample sample;
  sample.std = std::exp(bounded);
  sample.clamped = bounded != log_std;
  const double u = mean + sample.std * noise;
  sample.action = std::tanh(u);
  sample.log_probability = -0.5 * noise * noise - bounded - kHalfLogTwoPi - LogTanhSlope(u);
  return sample;
}

// Of one element of an action that was drawn before, as it is stored: what the density is now, and its
// gradients.
struct SquashedDensity {
  double log_probability = 0.0;
  double mean_gradient = 0.0;
  double log_std_gradient = 0.0;  // zero where log_std is outside its limits
};

inline SquashedDensity DensityOf(double action, double mean, double log_std, const GaussianLimits& limits) {
  // The largest float below 1: an action that was rounded to 1 came from about there or beyond.
  constexpr double kLargest = 1.0 - 0x1p-24;
  const double u = std::atanh(std::clamp(action, -kLargest, kLargest));
  const double bounded = std::clamp(log_std, limits.log_std_min, limits.log_std_max);
  const double inverse_std = std::exp(-bounded);
  const double distance = (u - mean) * inverse_std;
  return {.log_probability = -0.5 * distance * distance - bounded - kHalfLogTwoPi - LogTanhSlope(u),
          .mean_gradient = distance * inverse_std,
          .log_std_gradient = bounded != log_std ? 0.0 : distance * distance - 1.0};
}

// Gradients with respect to mean and log_std, from those of the action and of the log probability.
struct SquashedGradient {
  double mean = 0.0;
  double log_std = 0.0;
};

inline SquashedGradient SquashedBackward(const SquashedSample& sample, double noise, double action_gradient,
                                         double log_probability_gradient) {
  // d log_probability / du = 2 tanh(u).
  const double u_gradient = action_gradient * (1.0 - sample.action * sample.action) +
                            log_probability_gradient * 2.0 * sample.action;
  return {.mean = u_gradient,
          .log_std = sample.clamped ? 0.0 : u_gradient * sample.std * noise - log_probability_gradient};
}

}  // namespace dadrl::nn
