// The first convolution, whose input is bits, with AVX-512.
//
// Forward: five neighbouring bits select one of 32 sums of weights, precomputed for each plane, kernel row
// and output channel; one two-register permute looks it up for 16 images, in place of five multiply-adds.
// Weight gradient: the bits are lane masks of additions. Where all 16 images are empty (most of the route
// plane), both skip.
#pragma once

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/first_layer_patterns.h"
#include "common/nn/kernels/simd/vec_avx512.h"

namespace dadrl::nn::avx512 {

// Each output block is 8 pixels wide and reads 19 columns of its input rows, from column 16 * block on.
constexpr int kBlocks = 8;
constexpr int kBlockPixels = 8;
constexpr int kOutSize1 = Conv1::kOutSize;
constexpr int kLastBlockPixels = kOutSize1 - (kBlocks - 1) * kBlockPixels;

class FirstLayer {
 public:
  // Sums of weights for the forward pass; once a call.
  void SetParams(const float* weight, const float* bias) {
    const float mark = simd::NonFiniteMark<Simd>(weight);
    for (int co = 0; co < Conv1::kOut; ++co) {
      bias_[co] = bias[co] + mark;
      for (int row = 0; row < kKernelRows; ++row) {
        for (int pattern = 0; pattern < simd::kPatterns; ++pattern) {
          sums_of_[row][co][pattern] = simd::PatternSum<Simd>(weight, co, row, pattern);
        }
      }
    }
  }

  // context: 16 images of 4096 bytes.
  void SetGroup(const uint8_t* context) {
    for (int plane = 0; plane < kContextPlanes; ++plane) {
      for (int y = 0; y < Conv1::kInSize; ++y) {
        SetRow(context + (plane * kContextSide + y) * (kContextSide / 8), plane, y);
      }
    }
  }

  // Writes row y of out [4][61][61][16].
  void ForwardRow(int y, float* out) const {
    constexpr int kHalf = kBlockPixels / 2;
    out += y * kOutSize1 * kLanes;
    for (int block = 0; block < kBlocks - 1; ++block) {
      ForwardTile<0, kHalf>(y, block, out);
      ForwardTile<kHalf, kHalf>(y, block, out);
    }
    ForwardTile<0, kLastBlockPixels>(y, kBlocks - 1, out);
  }

  void ClearGradient() {
    for (float& sum : gradient_) sum = 0;
  }

  // Adds what row y of the output contributes; d_row [4][61][16].
  void AddGradientRow(int y, const float* d_row) {
    for (int row = 0; row < kKernelRows; ++row) GradientRow(y, row, d_row);
  }

  void StoreGradient(float* d_weight) const {
    for (int row = 0; row < kKernelRows; ++row) {
      for (int co = 0; co < Conv1::kOut; ++co) {
        for (int kx = 0; kx < Conv1::kKernel; ++kx) {
          d_weight[(co * kKernelRows + row) * Conv1::kKernel + kx] =
              Simd::Sum(Simd::Load(GradientOf(row) + (co * Conv1::kKernel + kx) * kLanes));
        }
      }
    }
  }

 private:
  static constexpr int kKernelRows = simd::kKernelRows1;
  static constexpr int kBlockColumns = 2 * kBlockPixels + Conv1::kKernel - 2;
  static constexpr int kGradientTile = Conv1::kOut * Conv1::kKernel * kLanes;

  // 128 columns of 16 images, context being row y of the first, to 8 overlapping words a lane.
  void SetRow(const uint8_t* context, int plane, int y) {
    const auto load = [context](int image) {
      return _mm_loadu_si128(reinterpret_cast<const __m128i*>(context + image * kContextImageBytes));
    };
    __m512i image[4];
    DADRL_UNROLL
    for (int i = 0; i < 4; ++i) {
      image[i] = _mm512_castsi128_si512(load(i));
      image[i] = _mm512_inserti32x4(image[i], load(i + 4), 1);
      image[i] = _mm512_inserti32x4(image[i], load(i + 8), 2);
      image[i] = _mm512_inserti32x4(image[i], load(i + 12), 3);
    }
    const __m512i low01 = _mm512_unpacklo_epi32(image[0], image[1]);
    const __m512i low23 = _mm512_unpacklo_epi32(image[2], image[3]);
    const __m512i high01 = _mm512_unpackhi_epi32(image[0], image[1]);
    const __m512i high23 = _mm512_unpackhi_epi32(image[2], image[3]);
    const __m512i column[5] = {_mm512_unpacklo_epi64(low01, low23), _mm512_unpackhi_epi64(low01, low23),
                               _mm512_unpacklo_epi64(high01, high23), _mm512_unpackhi_epi64(high01, high23),
                               _mm512_setzero_si512()};
    unsigned occupied = 0;
    DADRL_UNROLL
    for (int block = 0; block < kBlocks; ++block) {
      __m512i word = column[block / 2];
      if (block % 2 != 0) {
        word = _mm512_or_si512(_mm512_srli_epi32(word, 16), _mm512_slli_epi32(column[block / 2 + 1], 16));
      }
      _mm512_store_si512(words_[plane][y][block], word);
      const __mmask16 any = _mm512_test_epi32_mask(word, _mm512_set1_epi32((1 << kBlockColumns) - 1));
      occupied |= (any != 0 ? 1U : 0U) << block;
    }
    occupied_[plane][y] = static_cast<uint8_t>(occupied);
  }

  bool Occupied(int plane, int y, int block) const { return ((occupied_[plane][y] >> block) & 1) != 0; }

  template <int kFirst, int kPixels>
  void ForwardTile(int y, int block, float* out) const {
    __m512 sum[Conv1::kOut][kPixels];
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int x = 0; x < kPixels; ++x) sum[co][x] = _mm512_set1_ps(bias_[co]);
    }
    for (int row = 0; row < kKernelRows; ++row) {
      const int plane = row / Conv1::kKernel, in_y = 2 * y + row % Conv1::kKernel;
      if (!Occupied(plane, in_y, block)) continue;
      const __m512i word = _mm512_load_si512(words_[plane][in_y][block]);
      __m512i pattern[kPixels];
      DADRL_UNROLL
      for (int x = 0; x < kPixels; ++x) {
        pattern[x] = _mm512_srli_epi32(word, static_cast<unsigned>(2 * (kFirst + x)));
      }
      DADRL_UNROLL
      for (int co = 0; co < Conv1::kOut; ++co) {
        const __m512 low = _mm512_load_ps(sums_of_[row][co]);
        const __m512 high = _mm512_load_ps(sums_of_[row][co] + 16);
        DADRL_UNROLL
        for (int x = 0; x < kPixels; ++x) {
          sum[co][x] = _mm512_add_ps(sum[co][x], _mm512_permutex2var_ps(low, pattern[x], high));
        }
      }
    }
    out += (block * kBlockPixels + kFirst) * kLanes;
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int x = 0; x < kPixels; ++x) {
        _mm512_store_ps(out + (co * kOutSize1 * kOutSize1 + x) * kLanes, Simd::Relu(sum[co][x]));
      }
    }
  }

  float* GradientOf(int row) { return gradient_ + row * kGradientTile; }
  const float* GradientOf(int row) const { return gradient_ + row * kGradientTile; }

  void GradientRow(int y, int row, const float* d_row) {
    const int plane = row / Conv1::kKernel, in_y = 2 * y + row % Conv1::kKernel;
    if (occupied_[plane][in_y] == 0) return;
    float* const sums = GradientOf(row);
    __m512 sum[Conv1::kOut][Conv1::kKernel];
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int kx = 0; kx < Conv1::kKernel; ++kx) {
        sum[co][kx] = _mm512_load_ps(sums + (co * Conv1::kKernel + kx) * kLanes);
      }
    }
    for (int block = 0; block < kBlocks; ++block) {
      if (!Occupied(plane, in_y, block)) continue;
      const __m512i word = _mm512_load_si512(words_[plane][in_y][block]);
      const float* const gradients = d_row + block * kBlockPixels * kLanes;
      if (block + 1 < kBlocks) {
        GradientBlock<kBlockPixels>(word, gradients, sum);
      } else {
        GradientBlock<kLastBlockPixels>(word, gradients, sum);
      }
    }
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int kx = 0; kx < Conv1::kKernel; ++kx) {
        _mm512_store_ps(sums + (co * Conv1::kKernel + kx) * kLanes, sum[co][kx]);
      }
    }
  }

  // sum += value in the lanes of set; the second multiplies by one on the way. Some processors (AMD) add and
  // multiply in different pipes, so that half of each is twice as fast. Assembly, because clang 14 takes the
  // masked intrinsics apart into an addition and a masked move, and would see through the one.
  static DADRL_INLINE void AddWhereSet(__mmask16 set, __m512 value, __m512& sum) {
    asm("vaddps %[value], %[sum], %[sum] %{%[set]%}" : [sum] "+v"(sum) : [set] "Yk"(set), [value] "v"(value));
  }
  static DADRL_INLINE void FmaWhereSet(__mmask16 set, __m512 value, __m512 one, __m512& sum) {
    asm("vfmadd231ps %[value], %[one], %[sum] %{%[set]%}"
        : [sum] "+v"(sum)
        : [set] "Yk"(set), [value] "v"(value), [one] "v"(one));
  }

  template <int kPixels>
  static DADRL_INLINE void GradientBlock(__m512i word, const float* gradients,
                                         __m512 (&sum)[Conv1::kOut][Conv1::kKernel]) {
    const __m512 one = _mm512_set1_ps(1.0F);
    DADRL_UNROLL
    for (int x = 0; x < kPixels; ++x) {
      __m512 gradient[Conv1::kOut];
      DADRL_UNROLL
      for (int co = 0; co < Conv1::kOut; ++co) {
        gradient[co] = _mm512_load_ps(gradients + (co * kOutSize1 + x) * kLanes);
      }
      DADRL_UNROLL
      for (int kx = 0; kx < Conv1::kKernel; ++kx) {
        const __mmask16 set = _mm512_test_epi32_mask(word, _mm512_set1_epi32(1 << (2 * x + kx)));
        DADRL_UNROLL
        for (int co = 0; co < Conv1::kOut; ++co) {
          if ((co + kx) % 2 == 0) {
            AddWhereSet(set, gradient[co], sum[co][kx]);
          } else {
            FmaWhereSet(set, gradient[co], one, sum[co][kx]);
          }
        }
      }
    }
  }

  alignas(64) uint32_t words_[kContextPlanes][Conv1::kInSize][kBlocks][kLanes];
  alignas(64) float sums_of_[kKernelRows][Conv1::kOut][simd::kPatterns];
  alignas(64) float gradient_[kKernelRows * kGradientTile];
  float bias_[Conv1::kOut];
  uint8_t occupied_[kContextPlanes][Conv1::kInSize];  // bit per block: some image has a pixel there
};

}  // namespace dadrl::nn::avx512
