// The first convolution for one image with AVX2: seven neighbouring bits are the patterns of two output
// columns and select their four channels, eight sums of weights, at once.
#pragma once

#include <immintrin.h>
#include <stdint.h>
#include <string.h>

#include "common/nn/kernels/simd/first_layer_patterns.h"
#include "common/nn/kernels/simd/single_image.h"
#include "common/nn/kernels/simd/vec_avx2.h"

namespace dadrl::nn::avx2 {

class SingleFirstLayer {
 public:
  void SetParams(const float* weight, const float* bias) {
    const float mark = simd::NonFiniteMark<Simd>(weight);
    for (int lane = 0; lane < Simd::kFloats; ++lane) {
      const int co = lane % Conv1::kOut, column = lane / Conv1::kOut;
      bias_[lane] = bias[co] + mark;
      for (int row = 0; row < simd::kKernelRows1; ++row) {
        for (int bits = 0; bits < kPairPatterns; ++bits) {
          const int pattern = (bits >> (2 * column)) % simd::kPatterns;
          sums_of_[row][bits][lane] = simd::PatternSum<Simd>(weight, co, row, pattern);
        }
      }
    }
  }

  // Row y of the output, laid out as single_image.h says, from the whole image.
  void ForwardRow(const uint8_t* context, int y, float* out) const {
    // Eight output columns at a time, the 19 input columns from 16 block on.
    for (int block = 0; block < kBlocks; ++block) {
      __m256 pair[4];
      DADRL_UNROLL
      for (int i = 0; i < 4; ++i) pair[i] = Simd::Load(bias_);
      for (int row = 0; row < simd::kKernelRows1; ++row) {
        const int in_y = row / Conv1::kKernel * kContextSide + 2 * y + row % Conv1::kKernel;
        const uint32_t bits = Columns(context + in_y * kRowBytes, block);
        DADRL_UNROLL
        for (int i = 0; i < 4; ++i) {
          pair[i] = Simd::Add(pair[i], Simd::Load(sums_of_[row][(bits >> (4 * i)) % kPairPatterns]));
        }
      }
      StoreBlock(pair, out + block * 4);
    }
  }

 private:
  static constexpr int kPairPatterns = 1 << (Conv1::kKernel + 2);
  static constexpr int kBlocks = 8;
  static constexpr int kRowBytes = kContextSide / 8;

  // The last block needs only the columns that exist.
  static uint32_t Columns(const uint8_t* row, int block) {
    uint32_t bits = 0;
    if (block + 1 < kBlocks) {
      memcpy(&bits, row + 2 * block, 4);
    } else {
      uint16_t last;
      memcpy(&last, row + 2 * block, 2);
      bits = last;
    }
    return bits;
  }

  // pair[i]: (column 2i, channels 0-3), (column 2i + 1, channels 0-3).
  static DADRL_INLINE void StoreBlock(const __m256 (&pair)[4], float* out) {
    const __m256 low01 = _mm256_unpacklo_ps(pair[0], pair[1]), high01 = _mm256_unpackhi_ps(pair[0], pair[1]);
    const __m256 low23 = _mm256_unpacklo_ps(pair[2], pair[3]), high23 = _mm256_unpackhi_ps(pair[2], pair[3]);
    const __m256 channel[Conv1::kOut] = {
        _mm256_shuffle_ps(low01, low23, 0x44), _mm256_shuffle_ps(low01, low23, 0xEE),
        _mm256_shuffle_ps(high01, high23, 0x44), _mm256_shuffle_ps(high01, high23, 0xEE)};
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      const __m256 value = Simd::Relu(channel[co]);
      float* const to = out + co * 2 * simd::kHalfColumns;
      _mm_store_ps(to, _mm256_castps256_ps128(value));
      _mm_store_ps(to + simd::kHalfColumns, _mm256_extractf128_ps(value, 1));
    }
  }

  alignas(64) float sums_of_[simd::kKernelRows1][kPairPatterns][Simd::kFloats];
  alignas(64) float bias_[Simd::kFloats];
};

}  // namespace dadrl::nn::avx2
