// Reads a line of bits out of a bitmap: the inner loop of the bird's-eye view.
#pragma once

#include <cstdint>
#include <span>

#include "actor/sensing/bit_grid.h"

namespace dadrl {

// Points x + i * step_x, y + i * step_y of a grid's own coordinates, in 1/65536 of a cell.
struct GridLine {
  int32_t x = 0;
  int32_t y = 0;
  int32_t step_x = 0;
  int32_t step_y = 0;
};

// Bit i % 8 of byte i / 8 of `out` is the cell of point i; all points of the line are inside the grid. Any
// thread. Uses AVX2 where the processor has it; SampleBitsScalar is the same without.
void SampleBits(const BitGrid& grid, const GridLine& line, std::span<uint8_t> out);
void SampleBitsScalar(const BitGrid& grid, const GridLine& line, std::span<uint8_t> out);

}  // namespace dadrl
