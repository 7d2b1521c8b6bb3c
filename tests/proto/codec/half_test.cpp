#include "proto/codec/half.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dadrl {
namespace {

TEST(Half, EveryHalfSurvivesTheWayThroughFloat) {
  for (uint32_t bits = 0; bits <= 0xffff; ++bits) {
    const auto half = static_cast<uint16_t>(bits);
    if (std::isnan(FloatFromHalf(half))) continue;
    ASSERT_EQ(HalfFromFloat(FloatFromHalf(half)), half) << bits;
  }
}

TEST(Half, IsTheNearestAndTiesGoToEven) {
  for (uint32_t bits = 0; bits < 0x7bff; ++bits) {
    const float low = FloatFromHalf(static_cast<uint16_t>(bits));
    const float high = FloatFromHalf(static_cast<uint16_t>(bits + 1));
    const float middle = low + (high - low) / 2.0f;
    const auto even = static_cast<uint16_t>(bits % 2 == 0 ? bits : bits + 1);
    ASSERT_EQ(HalfFromFloat(middle), even) << bits;
    ASSERT_EQ(HalfFromFloat(std::nextafter(middle, low)), bits);
    ASSERT_EQ(HalfFromFloat(std::nextafter(middle, high)), bits + 1);
    ASSERT_EQ(HalfFromFloat(-std::nextafter(middle, high)), (bits + 1) | 0x8000);
  }
}

TEST(Half, SaturatesInsteadOfOverflowing) {
  EXPECT_EQ(FloatFromHalf(HalfFromFloat(1e30f)), 65504.0f);
  EXPECT_EQ(FloatFromHalf(HalfFromFloat(-1e30f)), -65504.0f);
  EXPECT_EQ(FloatFromHalf(HalfFromFloat(65520.0f)), 65504.0f);
  EXPECT_TRUE(std::isinf(FloatFromHalf(HalfFromFloat(std::numeric_limits<float>::infinity()))));
  EXPECT_TRUE(std::isnan(FloatFromHalf(HalfFromFloat(std::numeric_limits<float>::quiet_NaN()))));
}

}  // namespace
}  // namespace dadrl
