// The dense product: register tiles of broadcast-times-vector. Internal to the kernel translation units.
#pragma once

#include "common/nn/lanes/lane_kernels.h"
#include "common/nn/lanes/vector.h"

namespace dadrl::nn {
namespace {

#if defined(__AVX512F__)
constexpr int kTileRows = 12;  // 24 accumulators, 2 inputs, the broadcast a memory operand: of 32 registers
constexpr int kTileBlocks = 2;
constexpr int kWideBlocks = 8;
#elif defined(__AVX2__)
constexpr int kTileRows = 6;  // 12 accumulators of two halves, of 16 registers
constexpr int kTileBlocks = 1;
constexpr int kWideBlocks = 4;
#else
constexpr int kTileRows = 2;
constexpr int kTileBlocks = 1;
constexpr int kWideBlocks = 1;
#endif

template <int Rows, int Blocks>
DADRL_INLINE void StoreTile(const Product& p, Lanes (&sum)[Rows][Blocks], float* c, bool partial) {
#pragma GCC unroll 16
  for (int i = 0; i < Rows; ++i) {
#pragma GCC unroll 16
    for (int j = 0; j < Blocks; ++j) {
      float* to = c + i * p.c_row + j * p.c_block;
      const int width = partial && j == Blocks - 1 ? p.last_width : kLanes;
      Lanes value = sum[i][j];
      if (p.accumulate) value += width == kLanes ? Load(to) : LoadPart(to, width);
      if (p.relu) value = Relu(value);
      if (width == kLanes) {
        Store(to, value);
      } else {
        StorePart(to, value, width);
      }
    }
  }
}

template <int Rows, int Blocks>
__attribute__((noinline)) void Tile(const Product& p, int row, int block) {
  Lanes sum[Rows][Blocks];
#pragma GCC unroll 16
  for (int i = 0; i < Rows; ++i) {
    const Lanes start = p.bias == nullptr ? Lanes{} : Splat(p.bias[row + i]);
#pragma GCC unroll 16
    for (int j = 0; j < Blocks; ++j) sum[i][j] = start;
  }
  for (int s = 0; s < p.segments; ++s) {
    const float* a = p.a + row * p.a_row + s * p.a_segment;
    const float* b = p.b + block * p.b_block + s * p.b_segment;
    for (int k = 0; k < p.depth; ++k, a += p.a_depth, b += p.b_depth) {
      Lanes in[Blocks];
#pragma GCC unroll 16
      for (int j = 0; j < Blocks; ++j) in[j] = Load(b + j * p.b_block);
#pragma GCC unroll 16
      for (int i = 0; i < Rows; ++i) {
        const Lanes weight = Splat(a[i * p.a_row]);
#pragma GCC unroll 16
        for (int j = 0; j < Blocks; ++j) sum[i][j] += weight * in[j];
      }
    }
  }
  StoreTile<Rows, Blocks>(p, sum, p.c + row * p.c_row + block * p.c_block,
                          p.last_width < kLanes && block + Blocks == p.blocks);
}

// All rows of `Blocks` blocks, largest tiles first.
template <int Rows, int Blocks>
DADRL_INLINE int Strip(const Product& p, int row, int block) {
  for (; row + Rows <= p.rows; row += Rows) Tile<Rows, Blocks>(p, row, block);
  return row;
}

template <int Blocks>
DADRL_INLINE void Column(const Product& p, int block) {
  int row = Strip<kTileRows, Blocks>(p, 0, block);
  if constexpr (kTileRows > 8) row = Strip<8, Blocks>(p, row, block);
  if constexpr (kTileRows > 4) row = Strip<4, Blocks>(p, row, block);
  row = Strip<2, Blocks>(p, row, block);
  Strip<1, Blocks>(p, row, block);
}

// Few rows need many blocks at once to hide the latency of the additions.
template <int Rows>
DADRL_INLINE void WideRow(const Product& p) {
  int block = 0;
  for (; block + kWideBlocks <= p.blocks; block += kWideBlocks) Tile<Rows, kWideBlocks>(p, 0, block);
  for (; block < p.blocks; ++block) Tile<Rows, 1>(p, 0, block);
}

void Multiply(const Product& p) {
  if (p.rows == 1) return WideRow<1>(p);
  if (p.rows == 2) return WideRow<2>(p);
  int block = 0;
  for (; block + kTileBlocks <= p.blocks; block += kTileBlocks) Column<kTileBlocks>(p, block);
  for (; block < p.blocks; ++block) Column<1>(p, block);
}

}  // namespace
}  // namespace dadrl::nn
