#include "actor/sensing/bit_sampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <numbers>
#include <numeric>
#include <utility>

#include "common/util/isa.h"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace dadrl {
namespace {

constexpr int kTile = 8;  // points a side
constexpr int kTiles = GridSquare::kSize / kTile;
constexpr int kBlock = 4;  // cells a side
constexpr int kLineBytes = GridSquare::kSize / 8;

struct Tile {
  const BitGrid& grid;
  const GridSquare& square;
  int row;  // of its first point in the square
  int column;
  uint8_t* out;  // its first line's byte; the next line's is kLineBytes on
};

void SampleTileScalar(const Tile& tile) {
  const uint32_t* words = tile.grid.words().data();
  const int stride = tile.grid.stride_words();
  const GridSquare& square = tile.square;
  const int32_t* const first_x = square.x.data() + tile.row;
  const int32_t* const first_y = square.y.data() + tile.row;
  for (int line = 0; line < kTile; ++line) {
    int32_t x = first_x[line] + tile.column * square.step_x;
    int32_t y = first_y[line] + tile.column * square.step_y;
    uint32_t bits = 0;
    for (int i = 0; i < kTile; ++i) {
      const int column = x >> 16;
      bits |= (words[(y >> 16) * stride + column / 32] >> (column % 32) & 1U) << i;
      x += square.step_x;
      y += square.step_y;
    }
    tile.out[line * kLineBytes] = bits;
  }
}

#if defined(__x86_64__)
// A line of the tile at a time: one gather, then the wanted bit of each word is moved to its sign.
__attribute__((target("avx2"))) void SampleTileAvx2(const Tile& tile) {
  const GridSquare& square = tile.square;
  const auto* words = reinterpret_cast<const int*>(tile.grid.words().data());
  const __m256i stride = _mm256_set1_epi32(tile.grid.stride_words());
  const __m256i columns =
      _mm256_add_epi32(_mm256_set1_epi32(tile.column), _mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7));
  const __m256i from_x = _mm256_mullo_epi32(columns, _mm256_set1_epi32(square.step_x));
  const __m256i from_y = _mm256_mullo_epi32(columns, _mm256_set1_epi32(square.step_y));
  const __m256i highest_bit = _mm256_set1_epi32(31);
  for (int line = 0; line < kTile; ++line) {
    const __m256i x = _mm256_add_epi32(_mm256_set1_epi32(square.x.data()[tile.row + line]), from_x);
    const __m256i y = _mm256_add_epi32(_mm256_set1_epi32(square.y.data()[tile.row + line]), from_y);
    const __m256i column = _mm256_srli_epi32(x, 16);
    const __m256i grid_row = _mm256_srli_epi32(y, 16);
    const __m256i index =
        _mm256_add_epi32(_mm256_mullo_epi32(grid_row, stride), _mm256_srli_epi32(column, 5));
    const __m256i word = _mm256_i32gather_epi32(words, index, 4);
    // 31 - column % 32
    const __m256i shift = _mm256_andnot_si256(column, highest_bit);
    tile.out[line * kLineBytes] = _mm256_movemask_ps(_mm256_castsi256_ps(_mm256_sllv_epi32(word, shift)));
  }
}
#endif

// counts[row * (width + 1) + column]: the cells set above `row` and left of `column`.
std::vector<int> CountCells(const BitGrid& grid) {
  const int stride = grid.width() + 1;
  std::vector<int> counts(static_cast<size_t>(stride * (grid.height() + 1)));
  for (int row = 0; row < grid.height(); ++row) {
    int in_row = 0;
    const int* above = counts.data() + row * stride;
    int* below = counts.data() + (row + 1) * stride;
    for (int column = 0; column < grid.width(); ++column) {
      in_row += grid.Get(row, column) ? 1 : 0;
      below[column + 1] = above[column + 1] + in_row;
    }
  }
  return counts;
}

}  // namespace

BitSampler::BitSampler(BitGrid grid, double spacing)
    : grid_(std::move(grid)),
      // Half a tile's diagonal, and one more for what is rounded.
      reach_(static_cast<int>(std::ceil((kTile - 1) / 2.0 * std::numbers::sqrt2 * spacing)) + 1),
      block_columns_((grid_.width() + kBlock - 1) / kBlock) {
  const std::vector<int> counts = CountCells(grid_);
  const int block_rows = (grid_.height() + kBlock - 1) / kBlock;
  surroundings_.reserve(static_cast<size_t>(block_rows * block_columns_));
  for (int row = 0; row < block_rows; ++row) {
    for (int column = 0; column < block_columns_; ++column) {
      surroundings_.push_back(SurroundingsOf(row, column, counts));
    }
  }
}

BitSampler::Surroundings BitSampler::SurroundingsOf(int block_row, int block_column,
                                                    const std::vector<int>& counts) const {
  const int top = std::max(0, block_row * kBlock - reach_);
  const int left = std::max(0, block_column * kBlock - reach_);
  const int bottom = std::min(grid_.height(), (block_row + 1) * kBlock + reach_);
  const int right = std::min(grid_.width(), (block_column + 1) * kBlock + reach_);
  const auto count = [&](int row, int column) { return counts.data()[row * (grid_.width() + 1) + column]; };
  const int set = count(bottom, right) - count(top, right) - count(bottom, left) + count(top, left);
  if (set == 0) return Surroundings::kEmpty;
  return set == (bottom - top) * (right - left) ? Surroundings::kFull : Surroundings::kMixed;
}

BitSampler::Surroundings BitSampler::Around(const GridSquare& square, int row, int column) const {
  // Between the tile's innermost points.
  const int32_t* const x_of = square.x.data() + row + kTile / 2;
  const int32_t* const y_of = square.y.data() + row + kTile / 2;
  const int32_t steps = 2 * column + kTile - 1;
  const int32_t x = std::midpoint(x_of[-1], x_of[0]) + steps * square.step_x / 2;
  const int32_t y = std::midpoint(y_of[-1], y_of[0]) + steps * square.step_y / 2;
  return surroundings_.data()[y / 65536 / kBlock * block_columns_ + x / 65536 / kBlock];
}

// Most tiles are all road or all none: a look at their middle tells.
template <typename SampleTile>
void BitSampler::SampleTiles(const GridSquare& square, std::span<uint8_t> out, SampleTile sample_tile) const {
  assert(out.size() == GridSquare::kSize * kLineBytes);
  for (int row = 0; row < GridSquare::kSize; row += kTile) {
    uint8_t* const lines = out.data() + row * kLineBytes;
    std::array<Surroundings, kTiles> around;
    std::array<uint8_t, kLineBytes> plain{};
    for (size_t tile = 0; tile < kTiles; ++tile) {
      around[tile] = Around(square, row, tile * kTile);
      if (around[tile] == Surroundings::kFull) plain[tile] = 0xff;
    }
    for (size_t line = 0; line < kTile; ++line)
      std::memcpy(lines + line * kLineBytes, plain.data(), kLineBytes);
    for (size_t tile = 0; tile < kTiles; ++tile) {
      if (around[tile] != Surroundings::kMixed) continue;
      const int column = tile * kTile;
      sample_tile(Tile{grid_, square, row, column, lines + tile});
    }
  }
}

void BitSampler::Sample(const GridSquare& square, std::span<uint8_t> out) const {
  const Isa isa = ActiveIsa();
  SampleTiles(square, out, DADRL_FOR_ISA(isa, SampleTileScalar, SampleTileAvx2, SampleTileAvx2));
}

}  // namespace dadrl
