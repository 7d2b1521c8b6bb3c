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
constexpr size_t kLineBytes = GridSquare::kSize / 8;

struct Tile {
  const BitGrid& grid;
  const GridSquare& square;
  int row;  // of its first point in the square
  int column;
  uint8_t* out;  // its first line's byte; the next line's is kLineBytes on
};

void SampleTileScalar(const Tile& tile) {
  const uint32_t* words = tile.grid.words().data();
  const auto stride = static_cast<uint32_t>(tile.grid.stride_words());
  for (int line = 0; line < kTile; ++line) {
    const auto row = static_cast<size_t>(tile.row + line);
    auto x = static_cast<uint32_t>(tile.square.x[row] + tile.column * tile.square.step_x);
    auto y = static_cast<uint32_t>(tile.square.y[row] + tile.column * tile.square.step_y);
    uint32_t bits = 0;
    for (unsigned i = 0; i < kTile; ++i) {
      const uint32_t column = x >> 16U;
      bits |= (words[(y >> 16U) * stride + column / 32] >> (column % 32) & 1U) << i;
      x += static_cast<uint32_t>(tile.square.step_x);
      y += static_cast<uint32_t>(tile.square.step_y);
    }
    tile.out[static_cast<size_t>(line) * kLineBytes] = static_cast<uint8_t>(bits);
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
    const auto row = static_cast<size_t>(tile.row + line);
    const __m256i column = _mm256_srli_epi32(_mm256_add_epi32(_mm256_set1_epi32(square.x[row]), from_x), 16);
    const __m256i grid_row =
        _mm256_srli_epi32(_mm256_add_epi32(_mm256_set1_epi32(square.y[row]), from_y), 16);
    const __m256i index =
        _mm256_add_epi32(_mm256_mullo_epi32(grid_row, stride), _mm256_srli_epi32(column, 5));
    const __m256i word = _mm256_i32gather_epi32(words, index, 4);
    // 31 - column % 32
    const __m256i shift = _mm256_andnot_si256(column, highest_bit);
    tile.out[static_cast<size_t>(line) * kLineBytes] =
        static_cast<uint8_t>(_mm256_movemask_ps(_mm256_castsi256_ps(_mm256_sllv_epi32(word, shift))));
  }
}
#endif

// counts[row * (width + 1) + column]: the cells set above `row` and left of `column`.
std::vector<int> CountCells(const BitGrid& grid) {
  const size_t stride = static_cast<size_t>(grid.width()) + 1;
  std::vector<int> counts(stride * (static_cast<size_t>(grid.height()) + 1));
  for (int row = 0; row < grid.height(); ++row) {
    int in_row = 0;
    const int* above = &counts[static_cast<size_t>(row) * stride];
    int* below = &counts[static_cast<size_t>(row + 1) * stride];
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
  surroundings_.reserve(static_cast<size_t>(block_rows) * static_cast<size_t>(block_columns_));
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
  const auto count = [&](int row, int column) {
    return counts[static_cast<size_t>(row) * (static_cast<size_t>(grid_.width()) + 1) +
                  static_cast<size_t>(column)];
  };
  const int set = count(bottom, right) - count(top, right) - count(bottom, left) + count(top, left);
  if (set == 0) return Surroundings::kEmpty;
  return set == (bottom - top) * (right - left) ? Surroundings::kFull : Surroundings::kMixed;
}

BitSampler::Surroundings BitSampler::Around(const GridSquare& square, int row, int column) const {
  // Between the tile's innermost points.
  const auto line = static_cast<size_t>(row + kTile / 2);
  const int32_t steps = 2 * column + kTile - 1;
  const int32_t x = std::midpoint(square.x[line - 1], square.x[line]) + steps * square.step_x / 2;
  const int32_t y = std::midpoint(square.y[line - 1], square.y[line]) + steps * square.step_y / 2;
  return surroundings_[static_cast<size_t>(y / 65536 / kBlock) * static_cast<size_t>(block_columns_) +
                       static_cast<size_t>(x / 65536 / kBlock)];
}

// Most tiles are all road or all none: a look at their middle tells.
template <typename SampleTile>
void BitSampler::SampleTiles(const GridSquare& square, std::span<uint8_t> out, SampleTile sample_tile) const {
  assert(out.size() == GridSquare::kSize * kLineBytes);
  for (int row = 0; row < GridSquare::kSize; row += kTile) {
    uint8_t* const lines = out.data() + static_cast<size_t>(row) * kLineBytes;
    std::array<Surroundings, kTiles> around;
    std::array<uint8_t, kLineBytes> plain{};
    for (size_t tile = 0; tile < kTiles; ++tile) {
      around[tile] = Around(square, row, static_cast<int>(tile) * kTile);
      if (around[tile] == Surroundings::kFull) plain[tile] = 0xff;
    }
    for (size_t line = 0; line < kTile; ++line)
      std::memcpy(lines + line * kLineBytes, plain.data(), kLineBytes);
    for (size_t tile = 0; tile < kTiles; ++tile) {
      if (around[tile] != Surroundings::kMixed) continue;
      sample_tile(Tile{grid_, square, row, static_cast<int>(tile) * kTile, lines + tile});
    }
  }
}

void BitSampler::Sample(const GridSquare& square, std::span<uint8_t> out) const {
  const Isa isa = ActiveIsa();
  SampleTiles(square, out, DADRL_FOR_ISA(isa, SampleTileScalar, SampleTileAvx2, SampleTileAvx2));
}

}  // namespace dadrl
