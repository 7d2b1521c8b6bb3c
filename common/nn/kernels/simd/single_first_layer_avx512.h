// The first convolution for one image with AVX-512: lanes are output columns; see first_layer_avx512.h for
// the lookup.
#pragma once

#include <immintrin.h>
#include <stdint.h>

#include "common/nn/kernels/simd/first_layer_patterns.h"
#include "common/nn/kernels/simd/single_image.h"
#include "common/nn/kernels/simd/vec_avx512.h"

namespace dadrl::nn::avx512 {

class SingleFirstLayer {
 public:
  void SetParams(const float* weight, const float* bias) {
    const float mark = simd::NonFiniteMark<Simd>(weight);
    for (int co = 0; co < Conv1::kOut; ++co) {
      bias_[co] = bias[co] + mark;
      for (int row = 0; row < simd::kKernelRows1; ++row) {
        for (int pattern = 0; pattern < simd::kPatterns; ++pattern) {
          sums_of_[row][co][pattern] = simd::PatternSum<Simd>(weight, co, row, pattern);
        }
      }
    }
  }

  // Row y of the output, laid out as single_image.h says, from the whole image.
  void ForwardRow(const uint8_t* context, int y, float* out) const {
    // Lane i of vector (parity, half) is output column 32 half + 2 i + parity; its pattern starts at input
    // column 64 half + 4 i + 2 parity.
    __m512 sum[Conv1::kOut][kVectors];
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v) sum[co][v] = _mm512_set1_ps(bias_[co]);
    }
    for (int row = 0; row < simd::kKernelRows1; ++row) {
      const int in_y = row / Conv1::kKernel * kContextSide + 2 * y + row % Conv1::kKernel;
      const __m128i bits =
          _mm_loadu_si128(reinterpret_cast<const __m128i*>(context + in_y * (kContextSide / 8)));
      if (_mm_testz_si128(bits, bits) != 0) continue;
      __m512i pattern[kVectors];
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v) pattern[v] = Patterns(bits, v / 2, v % 2);
      DADRL_UNROLL
      for (int co = 0; co < Conv1::kOut; ++co) {
        const __m512 low = _mm512_load_ps(sums_of_[row][co]);
        const __m512 high = _mm512_load_ps(sums_of_[row][co] + 16);
        DADRL_UNROLL
        for (int v = 0; v < kVectors; ++v) {
          sum[co][v] = _mm512_add_ps(sum[co][v], _mm512_permutex2var_ps(low, pattern[v], high));
        }
      }
    }
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int v = 0; v < kVectors; ++v)
        _mm512_store_ps(out + (co * kVectors + v) * 16, Simd::Relu(sum[co][v]));
    }
  }

 private:
  static constexpr int kVectors = 4;  // (even, odd) x (left, right half)

  static DADRL_INLINE __m512i Patterns(__m128i bits, int parity, int half) {
    // Two neighbouring 16-bit words hold a lane's five bits; the ninth word, past the image, is zero.
    const __m512i lane = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    const __m512i first =
        _mm512_add_epi32(_mm512_slli_epi32(lane, 2), _mm512_set1_epi32(64 * half + 2 * parity));
    const __m512i word = _mm512_srli_epi32(first, 4);
    const __m512i words =
        _mm512_or_si512(word, _mm512_slli_epi32(_mm512_add_epi32(word, _mm512_set1_epi32(1)), 16));
    const __m512i gathered = _mm512_permutexvar_epi16(words, _mm512_zextsi128_si512(bits));
    return _mm512_srlv_epi32(gathered, _mm512_and_si512(first, _mm512_set1_epi32(15)));
  }

  alignas(64) float sums_of_[simd::kKernelRows1][Conv1::kOut][simd::kPatterns];
  float bias_[Conv1::kOut];
};

}  // namespace dadrl::nn::avx512
