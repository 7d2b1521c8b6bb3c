// The first convolution, whose input is bits, with AVX2: the rows in use are expanded to floats and
// multiplied.
#pragma once

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/vec_avx2.h"

namespace dadrl::nn::avx2 {

class FirstLayer {
 public:
  // The parameters are lent until the next call.
  void SetParams(const float* weight, const float* bias) {
    weight_ = weight;
    bias_ = bias;
  }

  // context: 16 images of 4096 bytes, lent until the next call. Rows must then be visited in increasing
  // order.
  void SetGroup(const uint8_t* context) {
    context_ = context;
    expanded_ = 0;
  }

  // Writes row y of out [4][61][61][16].
  void ForwardRow(int y, float* out) {
    Expand(y);
    for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
      int x = 0;
      for (; x + kTileColumns <= kSize; x += kTileColumns) ForwardTile<kTileColumns>(y, x, lane, out);
      if constexpr (kSize % kTileColumns != 0) ForwardTile<kSize % kTileColumns>(y, x, lane, out);
    }
  }

  void ClearGradient() { memset(gradient_, 0, sizeof(gradient_)); }

  // Adds what row y of the output contributes; d_row [4][61][16].
  void AddGradientRow(int y, const float* d_row) {
    Expand(y);
    for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
      for (int row = 0; row < kKernelRows; ++row) {
        for (int co = 0; co < Conv1::kOut; co += kGradientChannels) GradientTile(y, row, co, lane, d_row);
      }
    }
  }

  void StoreGradient(float* d_weight) const {
    for (int row = 0; row < kKernelRows; ++row) {
      for (int co = 0; co < Conv1::kOut; ++co) {
        for (int kx = 0; kx < kKernel; ++kx) {
          const float* const sums = gradient_[row][co][kx];
          d_weight[(co * kKernelRows + row) * kKernel + kx] =
              Simd::Sum(Simd::Add(Simd::Load(sums), Simd::Load(sums + Simd::kFloats)));
        }
      }
    }
  }

 private:
  static constexpr int kSize = Conv1::kOutSize, kKernel = Conv1::kKernel;
  static constexpr int kKernelRows = Conv1::kIn * kKernel;  // (plane, ky)
  static constexpr int kTileColumns = 3;
  static constexpr int kGradientChannels = 2;
  static constexpr int kSlots = 8;  // input rows held at once; five are in use
  static constexpr int kColumns = kContextSide;

  const float* Row(int plane, int in_y) const { return pixels_[plane][in_y % kSlots][0]; }

  // Makes the input rows of output row y available.
  void Expand(int y) {
    for (; expanded_ < 2 * y + kKernel; ++expanded_) {
      for (int plane = 0; plane < kContextPlanes; ++plane) {
        const uint8_t* const row = context_ + (plane * kContextSide + expanded_) * (kContextSide / 8);
        for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
          ExpandRow(row + lane * kContextImageBytes, pixels_[plane][expanded_ % kSlots][0] + lane);
        }
      }
    }
  }

  // One row of 8 images, row being in the first of them, to 0.0 and 1.0.
  static void ExpandRow(const uint8_t* row, float* pixels) {
    const __m256 one = _mm256_set1_ps(1.0F);
    for (int word = 0; word < kColumns / 32; ++word) {
      alignas(32) uint32_t words[Simd::kFloats];
      for (int n = 0; n < Simd::kFloats; ++n) memcpy(words + n, row + n * kContextImageBytes + 4 * word, 4);
      __m256i bits = _mm256_load_si256(reinterpret_cast<const __m256i*>(words));
      // Highest bit first: the sign of a lane says whether its pixel is set.
      for (int column = 31; column >= 0; --column, bits = _mm256_slli_epi32(bits, 1)) {
        const __m256 mask = _mm256_castsi256_ps(_mm256_srai_epi32(bits, 31));
        Simd::Store(pixels + (32 * word + column) * kLanes, _mm256_and_ps(mask, one));
      }
    }
  }

  template <int kPixels>
  void ForwardTile(int y, int x, int lane, float* out) const {
    __m256 sum[Conv1::kOut][kPixels];
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int j = 0; j < kPixels; ++j) sum[co][j] = Simd::Broadcast(bias_ + co);
    }
    for (int row = 0; row < kKernelRows; ++row) {
      const float* const pixels = Row(row / kKernel, 2 * y + row % kKernel) + 2 * x * kLanes + lane;
      const float* const taps = weight_ + row * kKernel;
      DADRL_UNROLL
      for (int kx = 0; kx < kKernel; ++kx) {
        __m256 pixel[kPixels];
        DADRL_UNROLL
        for (int j = 0; j < kPixels; ++j) pixel[j] = Simd::Load(pixels + (2 * j + kx) * kLanes);
        DADRL_UNROLL
        for (int co = 0; co < Conv1::kOut; ++co) {
          const __m256 w = Simd::Broadcast(taps + co * Conv1::kWeightsPerOut + kx);
          DADRL_UNROLL
          for (int j = 0; j < kPixels; ++j) sum[co][j] = Simd::Fma(w, pixel[j], sum[co][j]);
        }
      }
    }
    out += (y * kSize + x) * kLanes + lane;
    DADRL_UNROLL
    for (int co = 0; co < Conv1::kOut; ++co) {
      DADRL_UNROLL
      for (int j = 0; j < kPixels; ++j) {
        Simd::Store(out + (co * kSize * kSize + j) * kLanes, Simd::Relu(sum[co][j]));
      }
    }
  }

  void GradientTile(int y, int row, int co, int lane, const float* d_row) {
    const float* const pixels = Row(row / kKernel, 2 * y + row % kKernel) + lane;
    const float* const gradients = d_row + co * kSize * kLanes + lane;
    __m256 sum[kGradientChannels][kKernel];
    DADRL_UNROLL
    for (int c = 0; c < kGradientChannels; ++c) {
      DADRL_UNROLL
      for (int kx = 0; kx < kKernel; ++kx) sum[c][kx] = Simd::Load(gradient_[row][co + c][kx] + lane);
    }
    for (int x = 0; x < kSize; ++x) {
      __m256 gradient[kGradientChannels];
      DADRL_UNROLL
      for (int c = 0; c < kGradientChannels; ++c) {
        gradient[c] = Simd::Load(gradients + (c * kSize + x) * kLanes);
      }
      DADRL_UNROLL
      for (int kx = 0; kx < kKernel; ++kx) {
        const __m256 pixel = Simd::Load(pixels + (2 * x + kx) * kLanes);
        DADRL_UNROLL
        for (int c = 0; c < kGradientChannels; ++c) sum[c][kx] = Simd::Fma(gradient[c], pixel, sum[c][kx]);
      }
    }
    DADRL_UNROLL
    for (int c = 0; c < kGradientChannels; ++c) {
      DADRL_UNROLL
      for (int kx = 0; kx < kKernel; ++kx) Simd::Store(gradient_[row][co + c][kx] + lane, sum[c][kx]);
    }
  }

  alignas(64) float pixels_[kContextPlanes][kSlots][kColumns][kLanes];
  alignas(64) float gradient_[kKernelRows][Conv1::kOut][kKernel][kLanes];
  const float* weight_;
  const float* bias_;
  const uint8_t* context_;
  int expanded_;  // input rows so far
};

}  // namespace dadrl::nn::avx2
