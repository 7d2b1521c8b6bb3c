// Forward pass of one convolution over a group of 16 images: [channel][row][column][16 images].
#pragma once

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/unroll.h"

namespace dadrl::nn::simd {

// Output rows y .. y + kRows - 1, columns x .. x + kColumns - 1 of channels co .. co + kChannels - 1, for the
// lanes that in and out point at. The tile's sums stay in registers.
template <class Simd, class Shape, int kChannels, int kRows, int kColumns>
void ForwardTile(const float* in, const float* weight, const float* bias, float* out, int co, int y, int x) {
  using Float = typename Simd::Float;
  constexpr int kKernel = Shape::kKernel;
  constexpr int kInRow = Shape::kInSize * kLanes, kInPlane = Shape::kInSize * kInRow;
  constexpr int kOutRow = Shape::kOutSize * kLanes, kOutPlane = Shape::kOutSize * kOutRow;
  Float sum[kChannels][kRows][kColumns];
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    const Float b = Simd::Broadcast(bias + co + c);
    DADRL_UNROLL
    for (int i = 0; i < kRows; ++i) {
      DADRL_UNROLL
      for (int j = 0; j < kColumns; ++j) sum[c][i][j] = b;
    }
  }
  in += 2 * y * kInRow + 2 * x * kLanes;
  weight += co * Shape::kWeightsPerOut;
  for (int ci = 0; ci < Shape::kIn; ++ci) {
    for (int ky = 0; ky < kKernel; ++ky) {
      const float* const pixels = in + ci * kInPlane + ky * kInRow;
      const float* const taps = weight + (ci * kKernel + ky) * kKernel;
      DADRL_UNROLL
      for (int kx = 0; kx < kKernel; ++kx) {
        Float w[kChannels];
        DADRL_UNROLL
        for (int c = 0; c < kChannels; ++c) w[c] = Simd::Broadcast(taps + c * Shape::kWeightsPerOut + kx);
        DADRL_UNROLL
        for (int i = 0; i < kRows; ++i) {
          DADRL_UNROLL
          for (int j = 0; j < kColumns; ++j) {
            const Float pixel = Simd::Load(pixels + 2 * i * kInRow + (2 * j + kx) * kLanes);
            DADRL_UNROLL
            for (int c = 0; c < kChannels; ++c) sum[c][i][j] = Simd::Fma(w[c], pixel, sum[c][i][j]);
          }
        }
      }
    }
  }
  out += co * kOutPlane + y * kOutRow + x * kLanes;
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int i = 0; i < kRows; ++i) {
      DADRL_UNROLL
      for (int j = 0; j < kColumns; ++j) {
        Simd::Store(out + c * kOutPlane + i * kOutRow + j * kLanes, Simd::Relu(sum[c][i][j]));
      }
    }
  }
}

// Output rows y .. y + kRows - 1 of all channels, in tiles of kChannels x kRows x kColumns and a narrower
// last.
template <class Simd, class Shape, int kChannels, int kRows, int kColumns>
void ForwardRows(const float* in, const float* weight, const float* bias, float* out, int y) {
  constexpr int kLast = Shape::kOutSize % kColumns;
  static_assert(Shape::kOut % kChannels == 0);
  for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
    for (int co = 0; co < Shape::kOut; co += kChannels) {
      for (int x = 0; x + kColumns <= Shape::kOutSize; x += kColumns) {
        ForwardTile<Simd, Shape, kChannels, kRows, kColumns>(in + lane, weight, bias, out + lane, co, y, x);
      }
      if constexpr (kLast != 0) {
        ForwardTile<Simd, Shape, kChannels, kRows, kLast>(in + lane, weight, bias, out + lane, co, y,
                                                          Shape::kOutSize - kLast);
      }
    }
  }
}

}  // namespace dadrl::nn::simd
