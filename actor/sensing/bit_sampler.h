// Reads a turned square of points out of a bitmap: the inner loop of the bird's-eye view.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "actor/sensing/bit_grid.h"

namespace dadrl {

// Point (row, column) is x[row] + column * step_x, y[row] + column * step_y in 1/65536 of a cell. Lines are
// as far from each other as the points of a line, at right angles to them.
struct GridSquare {
  static constexpr int kSize = 128;

  std::array<int32_t, kSize> x{};
  std::array<int32_t, kSize> y{};
  int32_t step_x = 0;
  int32_t step_y = 0;
};

// Owns the bitmap. Immutable: any thread may use it.
class BitSampler {
 public:
  // `spacing`: how far neighbouring points of a square are apart, in cells; at most.
  BitSampler(BitGrid grid, double spacing);

  const BitGrid& grid() const { return grid_; }

  // Bit c % 8 of byte 16 r + c / 8 of `out` is the cell of point (r, c); all points are inside the grid. The
  // same on every instruction set (common/util/isa.h).
  void Sample(const GridSquare& square, std::span<uint8_t> out) const;

 private:
  // What the cells around a block of cells are, as far as a tile of 8 x 8 points reaches.
  enum class Surroundings : uint8_t { kEmpty, kFull, kMixed };

  Surroundings SurroundingsOf(int block_row, int block_column, const std::vector<int>& counts) const;
  Surroundings Around(const GridSquare& square, int row, int column) const;
  template <typename SampleTile>
  void SampleTiles(const GridSquare& square, std::span<uint8_t> out, SampleTile sample_tile) const;

  BitGrid grid_;
  int reach_;  // of a tile's points from the cell in its middle, in cells
  int block_columns_;
  std::vector<Surroundings> surroundings_;  // by block, row-major
};

}  // namespace dadrl
