#include "common/util/random.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <vector>

namespace dadrl {
namespace {

// Reference: the authors' C code of xoshiro256++ started from the state {1, 2, 3, 4}.
TEST(Random, FollowsXoshiro256PlusPlus) {
  Random random(Random::State{{1, 2, 3, 4}});
  const std::vector<uint64_t> expected = {41943041ull, 58720359ull, 3588806011781223ull, 3591011842654386ull};
  for (const uint64_t value : expected) EXPECT_EQ(random.Next(), value);
}

TEST(Random, ContinuesFromASavedState) {
  Random random(7);
  for (int i = 0; i < 100; ++i) random.Normal();
  Random copy(random.state());
  for (int i = 0; i < 100; ++i) EXPECT_EQ(random.Normal(), copy.Normal());
}

TEST(Random, UniformAndNormalHaveTheirMoments) {
  Random random(1);
  constexpr int kDraws = 200000;
  double uniform_sum = 0, normal_sum = 0, normal_square = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = random.Uniform(-2.0, 4.0);
    ASSERT_GE(u, -2.0);
    ASSERT_LT(u, 4.0);
    uniform_sum += u;
    const double n = random.Normal();
    ASSERT_TRUE(std::isfinite(n));
    normal_sum += n;
    normal_square += n * n;
  }
  EXPECT_NEAR(uniform_sum / kDraws, 1.0, 0.02);  // 5 standard errors
  EXPECT_NEAR(normal_sum / kDraws, 0.0, 0.012);
  EXPECT_NEAR(normal_square / kDraws, 1.0, 0.016);
}

TEST(Random, BelowIsUniform) {
  Random random(3);
  constexpr int kBins = 7, kDraws = 70000;
  std::vector<int> counts(kBins);
  for (int i = 0; i < kDraws; ++i) ++counts[random.Below(kBins)];
  double chi_square = 0;
  for (const int count : counts) chi_square += std::pow(count - kDraws / kBins, 2) / (kDraws / kBins);
  EXPECT_LT(chi_square, 22.5);  // 6 degrees of freedom, p = 0.001
}

TEST(Random, DerivedSeedsDiffer) {
  std::set<uint64_t> seeds;
  for (uint64_t seed = 0; seed < 50; ++seed) {
    for (uint64_t index = 0; index < 50; ++index) seeds.insert(DeriveSeed(seed, index));
  }
  EXPECT_EQ(seeds.size(), 2500u);
}

}  // namespace
}  // namespace dadrl
