#include "actor/sensing/sample_bits.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "common/util/random.h"

namespace dadrl {
namespace {

constexpr double kOne = 65536.0;

BitGrid Speckled(Random& random) {
  BitGrid grid(331, 270);
  for (int i = 0; i < 400; ++i) {
    const Point p{random.Uniform(0, 331), random.Uniform(0, 270)};
    grid.FillStrip(p, p + Point{random.Uniform(-9, 9), random.Uniform(-9, 9)}, random.Uniform(0.4, 3),
                   BitGrid::Ends::kRound);
  }
  return grid;
}

TEST(SampleBits, ReadsTheCellsUnderTheLineOnEveryProcessor) {
  Random random(11);
  const BitGrid grid = Speckled(random);
  int set = 0;
  for (int trial = 0; trial < 500; ++trial) {
    const double heading = random.Uniform(-4, 4);
    const Point from{random.Uniform(130, 200), random.Uniform(130, 140)};
    const GridLine line{static_cast<int32_t>(from.x * kOne), static_cast<int32_t>(from.y * kOne),
                        static_cast<int32_t>(std::cos(heading) * kOne),
                        static_cast<int32_t>(std::sin(heading) * kOne)};
    std::array<uint8_t, 16> fast{};
    std::array<uint8_t, 16> scalar{};
    SampleBits(grid, line, fast);
    SampleBitsScalar(grid, line, scalar);
    ASSERT_EQ(fast, scalar);
    for (int i = 0; i < 128; ++i) {
      const int column = (line.x + i * line.step_x) >> 16;
      const int row = (line.y + i * line.step_y) >> 16;
      const bool bit = (fast[static_cast<size_t>(i / 8)] >> (i % 8) & 1) != 0;
      ASSERT_EQ(bit, grid.Get(row, column)) << trial << ' ' << i;
      set += bit ? 1 : 0;
    }
  }
  EXPECT_GT(set, 5000);
  EXPECT_LT(set, 59000);
}

}  // namespace
}  // namespace dadrl
