#include "common/nn/adam.h"

#include <array>
#include <cmath>

#include "tests/common/nn/lane_test.h"
#include "tests/golden/golden.h"

namespace dadrl::nn {
namespace {

using AdamTest = EveryIsa;

TEST_P(AdamTest, MatchesTheTextbookOverSeveralStepsAndThreads) {
  constexpr size_t kCount = 48;
  const AdamSettings settings{.learning_rate = 3e-3};
  FloatBuffer parameters(kCount), target(kCount), gradient1(kCount), gradient2(kCount);
  AdamMoments moments(kCount);
  std::ranges::copy(golden::Uniform(1, kCount), parameters.data());
  std::vector<double> p(parameters.data(), parameters.data() + kCount), t(kCount), m(kCount), v(kCount);
  for (uint64_t step = 1; step <= 5; ++step) {
    std::ranges::copy(golden::Uniform(10 + step, kCount), gradient1.data());
    std::ranges::copy(golden::Uniform(20 + step, kCount), gradient2.data());
    for (size_t i = 0; i < kCount; ++i) {
      const double g = static_cast<double>(gradient1.data()[i]) + static_cast<double>(gradient2.data()[i]);
      m[i] = 0.9 * m[i] + 0.1 * g;
      v[i] = 0.999 * v[i] + 0.001 * g * g;
      const double n = static_cast<double>(step);
      p[i] -= 3e-3 * (m[i] / (1 - std::pow(0.9, n))) / (std::sqrt(v[i] / (1 - std::pow(0.999, n))) + 1e-8);
      t[i] += 0.1 * (p[i] - t[i]);
    }
    const std::array<float*, 2> gradients = {gradient1.data(), gradient2.data()};
    for (int member = 0; member < 2; ++member) {
      const Range share = ShareOf({0, kCount}, member, 2);
      EXPECT_TRUE(ApplyAdam(kernels(), settings,
                            {.range = share,
                             .parameters = parameters.data() + share.first,
                             .target = target.data() + share.first,
                             .tau = 0.1,
                             .moments = &moments,
                             .gradients = gradients,
                             .step = step}));
    }
    for (size_t i = 0; i < kCount; ++i) {
      EXPECT_NEAR(parameters.data()[i], p[i], 2e-6);
      EXPECT_NEAR(target.data()[i], t[i], 2e-6);
      EXPECT_EQ(gradient1.data()[i], 0.0f);
      EXPECT_EQ(gradient2.data()[i], 0.0f);
    }
  }
}

TEST_P(AdamTest, ReportsAParameterThatIsNoLongerFinite) {
  for (const float bad : {std::nanf(""), HUGE_VALF}) {
    FloatBuffer parameters(32), gradient(32);
    AdamMoments moments(32);
    gradient.data()[17] = bad;
    float* const gradients[] = {gradient.data()};
    EXPECT_FALSE(ApplyAdam(
        kernels(), {},
        {.range = {0, 32}, .parameters = parameters.data(), .moments = &moments, .gradients = gradients}));
  }
}

INSTANTIATE_TEST_SUITE_P(Isa, AdamTest, AllIsas(), IsaTestName);

TEST(ShareOfTest, SharesAreDisjointVectorsThatCoverTheWhole) {
  for (const int members : {1, 2, 3, 7}) {
    size_t next = 32;
    for (int member = 0; member < members; ++member) {
      const Range share = ShareOf({32, 80}, member, members);
      EXPECT_EQ(share.first, next);
      EXPECT_EQ(share.count % kLanes, 0u);
      next = share.first + share.count;
    }
    EXPECT_EQ(next, 32u + 80u);
  }
}

}  // namespace
}  // namespace dadrl::nn
