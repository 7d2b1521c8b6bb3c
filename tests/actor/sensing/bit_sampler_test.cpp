#include "actor/sensing/bit_sampler.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "common/util/random.h"
#include "tests/common/util/isa_scope.h"

namespace dadrl {
namespace {

constexpr int kSize = GridSquare::kSize;
constexpr double kOne = 65536.0;
constexpr double kSpacing = 1.95;
constexpr int kCells = 500;

// The square's middle at `centre`; columns along `heading`, rows to its right.
GridSquare Turned(Point centre, double heading, double spacing) {
  const Point along = spacing * Forward(heading);
  const Point across{along.y, -along.x};
  GridSquare square;
  square.step_x = static_cast<int32_t>(std::lround(along.x * kOne));
  square.step_y = static_cast<int32_t>(std::lround(along.y * kOne));
  for (int row = 0; row < kSize; ++row) {
    const Point start = centre + (row - kSize / 2) * across - (kSize / 2) * along;
    square.x[static_cast<size_t>(row)] = static_cast<int32_t>(std::lround(start.x * kOne));
    square.y[static_cast<size_t>(row)] = static_cast<int32_t>(std::lround(start.y * kOne));
  }
  return square;
}

// Compares every point with the cell it is in. Returns how many are set.
int CheckEveryPoint(const BitSampler& sampler, const GridSquare& square) {
  std::vector<uint8_t> fast(kSize * kSize / 8, 0xaa);
  sampler.Sample(square, fast);
  for (const Isa isa : {Isa::kScalar, Isa::kAvx2}) {
    const IsaScope scope(isa);
    std::vector<uint8_t> other(kSize * kSize / 8, 0x55);
    sampler.Sample(square, other);
    EXPECT_EQ(fast, other) << IsaName(ActiveIsa());
  }
  int set = 0;
  int wrong = 0;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const int x = (square.x[static_cast<size_t>(row)] + column * square.step_x) >> 16;
      const int y = (square.y[static_cast<size_t>(row)] + column * square.step_y) >> 16;
      const bool bit = (fast[static_cast<size_t>(row * kSize + column) / 8] >> (column % 8) & 1) != 0;
      wrong += bit != sampler.grid().Get(y, x) ? 1 : 0;
      set += bit ? 1 : 0;
    }
  }
  EXPECT_EQ(wrong, 0);
  return set;
}

Point AnyCentre(Random& random) {
  return {random.Uniform(190, kCells - 190), random.Uniform(190, kCells - 190)};
}

// Half set, half not, in patches from a cell to some tiles.
TEST(BitSampler, ReadsTheCellUnderEveryPointOnEveryProcessor) {
  Random random(11);
  BitGrid grid(kCells, kCells);
  for (int i = 0; i < 250; ++i) {
    const Point p{random.Uniform(0, kCells), random.Uniform(0, kCells)};
    grid.FillStrip(p, p + Point{random.Uniform(-60, 60), random.Uniform(-60, 60)}, random.Uniform(0.4, 18),
                   BitGrid::Ends::kRound);
  }
  const BitSampler sampler(std::move(grid), kSpacing);
  int set = 0;
  for (int trial = 0; trial < 200; ++trial) {
    set += CheckEveryPoint(sampler, Turned(AnyCentre(random), random.Uniform(-4, 4), kSpacing));
  }
  EXPECT_GT(set, 200 * kSize * kSize / 4);
  EXPECT_LT(set, 200 * kSize * kSize * 3 / 4);
}

// The middle of a cell that some point of the square is in.
Point AnySampledCell(Random& random, const GridSquare& square) {
  const size_t row = random.Below(kSize);
  const auto column = static_cast<int>(random.Below(kSize));
  return {((square.x[row] + column * square.step_x) >> 16) + 0.5,
          ((square.y[row] + column * square.step_y) >> 16) + 0.5};
}

// What a look at the middle of a tile could miss.
TEST(BitSampler, SeesSingleCellsOfRoad) {
  Random random(12);
  for (int trial = 0; trial < 60; ++trial) {
    const GridSquare square = Turned(AnyCentre(random), random.Uniform(-4, 4), kSpacing);
    BitGrid grid(kCells, kCells);
    for (int i = 0; i < 64; ++i) {
      const Point cell = AnySampledCell(random, square);
      grid.FillStrip(cell, cell, 0.1, BitGrid::Ends::kRound);
    }
    EXPECT_GE(CheckEveryPoint(BitSampler(std::move(grid), kSpacing), square), 50);
  }
}

TEST(BitSampler, SeesASingleHoleInTheRoad) {
  Random random(13);
  for (int trial = 0; trial < 60; ++trial) {
    const GridSquare square = Turned(AnyCentre(random), random.Uniform(-4, 4), kSpacing);
    const Point hole = AnySampledCell(random, square);
    BitGrid grid(kCells, kCells);
    const auto fill = [&](double left, double right, double low, double high) {
      const double middle = (low + high) / 2;
      grid.FillStrip({left, middle}, {right, middle}, (high - low) / 2, BitGrid::Ends::kSquare);
    };
    fill(0, kCells, 0, hole.y - 0.5);
    fill(0, kCells, hole.y + 0.5, kCells);
    fill(0, hole.x - 0.5, 0, kCells);
    fill(hole.x + 0.5, kCells, 0, kCells);
    EXPECT_EQ(CheckEveryPoint(BitSampler(std::move(grid), kSpacing), square), kSize * kSize - 1);
  }
}

}  // namespace
}  // namespace dadrl
