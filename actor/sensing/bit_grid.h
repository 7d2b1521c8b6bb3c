// A bitmap of one bit a cell that shapes are drawn into.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "actor/sim/geometry.h"

namespace dadrl {

// Cell (row, column) covers [column, column + 1) x [row, row + 1) of the grid's own coordinates; a shape sets
// the cells whose centre it contains. What lies outside is cut off. Not thread safe while it is drawn into;
// drawing allocates only in FillPolygon.
class BitGrid {
 public:
  // Whether the ends of a strip are cut square or carry half a disc.
  enum class Ends { kSquare, kRound };

  BitGrid(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  bool Get(int row, int column) const { return (words_[Index(row, column)] >> (column % 32) & 1U) != 0; }
  // Row-major, stride_words() words a row, column c is bit c % 32 of word c / 32.
  std::span<const uint32_t> words() const { return words_; }
  int stride_words() const { return stride_; }

  void Clear();
  // All points within `half_width` of the segment a-b, the ends as asked.
  void FillStrip(Point a, Point b, double half_width, Ends ends);
  // Even-odd interior of a closed polygon given without its closing point.
  void FillPolygon(std::span<const Point> polygon);

 private:
  size_t Index(int row, int column) const { return static_cast<size_t>(row * stride_ + column / 32); }
  // Cells of `row` whose centre is within [left, right].
  void FillSpan(int row, double left, double right);

  int width_;
  int height_;
  int stride_;
  std::vector<uint32_t> words_;
};

}  // namespace dadrl
