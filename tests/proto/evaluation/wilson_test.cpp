#include "proto/evaluation/wilson.h"

#include <gtest/gtest.h>

namespace dadrl {
namespace {

// Newcombe (1998), table I: 81 of 263 and 15 of 148, 0 of 20, 1 of 29 (method 3, Wilson).
TEST(WilsonInterval, AgreesWithThePublishedExamples) {
  const auto [a_low, a_high] = WilsonInterval(81, 263);
  EXPECT_NEAR(a_low, 0.2553, 5e-5);
  EXPECT_NEAR(a_high, 0.3662, 5e-5);
  const auto [b_low, b_high] = WilsonInterval(15, 148);
  EXPECT_NEAR(b_low, 0.0624, 5e-5);
  EXPECT_NEAR(b_high, 0.1605, 5e-5);
  const auto [c_low, c_high] = WilsonInterval(0, 20);
  EXPECT_EQ(c_low, 0.0);
  EXPECT_NEAR(c_high, 0.1611, 5e-5);
  const auto [d_low, d_high] = WilsonInterval(1, 29);
  EXPECT_NEAR(d_low, 0.0061, 5e-5);
  EXPECT_NEAR(d_high, 0.1718, 5e-5);
}

TEST(WilsonInterval, IsSymmetricAndKnowsNothingWithoutTrials) {
  const auto [low, high] = WilsonInterval(3, 50);
  const auto [mirrored_low, mirrored_high] = WilsonInterval(47, 50);
  EXPECT_NEAR(low, 1 - mirrored_high, 1e-12);
  EXPECT_NEAR(high, 1 - mirrored_low, 1e-12);
  EXPECT_EQ(WilsonInterval(50, 50).second, 1.0);
  EXPECT_EQ(WilsonInterval(0, 0), (std::pair{0.0, 1.0}));
}

}  // namespace
}  // namespace dadrl
