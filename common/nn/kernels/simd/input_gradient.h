// Gradient of one convolution with respect to its input, over a group of 16 images.
#pragma once

#include "common/nn/kernels/conv_params.h"
#include "common/nn/kernels/simd/unroll.h"

namespace dadrl::nn::simd {

// One row (y) of d_in for channels ci .. ci + kChannels - 1 and the columns kFirst, kFirst + kStep, ...,
// kCount of them, for the lanes that the pointers are at. With kStep 2 only the taps of the columns' parity
// are visited. The columns are template arguments so that the taps which fall off the image are dropped at
// compile time: no padding, no wasted products. in is the layer's input, whose ReLU the gradient passes;
// d_in_row points at row y of channel 0 and in_row likewise, planes in_plane and d_in_plane floats apart.
template <class Simd, class Shape, int kChannels, int kFirst, int kStep, int kCount>
void InputGradientTile(const float* d_out, const float* weight, const float* in_row, int in_plane,
                       float* d_in_row, int d_in_plane, int ci, int y) {
  using Float = typename Simd::Float;
  constexpr int kKernel = Shape::kKernel, kOutSize = Shape::kOutSize;
  constexpr int kOutRow = kOutSize * kLanes, kOutPlane = kOutSize * kOutRow;
  Float sum[kChannels][kCount];
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int j = 0; j < kCount; ++j) sum[c][j] = Simd::Zero();
  }
  for (int ky = y & 1; ky < kKernel; ky += 2) {
    const int out_y = (y - ky) / 2;
    if (y < ky || out_y >= kOutSize) continue;
    const float* gradients = d_out + out_y * kOutRow;
    const float* taps = weight + ci * Shape::kTaps + ky * kKernel;
    for (int co = 0; co < Shape::kOut; ++co, gradients += kOutPlane, taps += Shape::kWeightsPerOut) {
      Float w[kChannels][kKernel];
      DADRL_UNROLL
      for (int c = 0; c < kChannels; ++c) {
        DADRL_UNROLL
        for (int kx = 0; kx < kKernel; ++kx) w[c][kx] = Simd::Broadcast(taps + c * Shape::kTaps + kx);
      }
      constexpr int kLast = kFirst + kStep * (kCount - 1);
      constexpr int kOutFirst = kFirst < kKernel ? 0 : (kFirst - kKernel + 2) / 2;
      constexpr int kOutLast = kLast / 2 < kOutSize ? kLast / 2 : kOutSize - 1;
      DADRL_UNROLL
      for (int x = kOutFirst; x <= kOutLast; ++x) {
        const Float gradient = Simd::Load(gradients + x * kLanes);
        DADRL_UNROLL
        for (int kx = 0; kx < kKernel; ++kx) {
          const int offset = 2 * x + kx - kFirst;
          if (offset < 0 || offset % kStep != 0 || offset / kStep >= kCount) continue;
          DADRL_UNROLL
          for (int c = 0; c < kChannels; ++c) {
            sum[c][offset / kStep] = Simd::Fma(w[c][kx], gradient, sum[c][offset / kStep]);
          }
        }
      }
    }
  }
  DADRL_UNROLL
  for (int c = 0; c < kChannels; ++c) {
    DADRL_UNROLL
    for (int j = 0; j < kCount; ++j) {
      const int column = (kFirst + kStep * j) * kLanes;
      const Float output = Simd::Load(in_row + (ci + c) * in_plane + column);
      Simd::Store(d_in_row + (ci + c) * d_in_plane + column, Simd::ReluGradient(output, sum[c][j]));
    }
  }
}

// Columns kFirst, kFirst + kStep, ... up to the image's edge, in tiles of kCount and a narrower last one.
template <class Simd, class Shape, int kChannels, int kFirst, int kStep, int kCount>
void InputGradientRow(const float* d_out, const float* weight, const float* in_row, int in_plane,
                      float* d_in_row, int d_in_plane, int ci, int y) {
  constexpr int kRemaining = (Shape::kInSize - kFirst + kStep - 1) / kStep;
  if constexpr (kRemaining > 0) {
    constexpr int kTile = kRemaining < kCount ? kRemaining : kCount;
    InputGradientTile<Simd, Shape, kChannels, kFirst, kStep, kTile>(d_out, weight, in_row, in_plane, d_in_row,
                                                                    d_in_plane, ci, y);
    InputGradientRow<Simd, Shape, kChannels, kFirst + kStep * kTile, kStep, kCount>(
        d_out, weight, in_row, in_plane, d_in_row, d_in_plane, ci, y);
  }
}

// Row y of d_in, all channels; d_in_row points at the row in channel 0.
template <class Simd, class Shape, int kChannels, int kStep, int kCount>
void InputGradient(const float* d_out, const float* weight, const float* in, float* d_in_row, int d_in_plane,
                   int y) {
  constexpr int kInRow = Shape::kInSize * kLanes, kInPlane = Shape::kInSize * kInRow;
  static_assert(Shape::kIn % kChannels == 0);
  for (int lane = 0; lane < kLanes; lane += Simd::kFloats) {
    for (int ci = 0; ci < Shape::kIn; ci += kChannels) {
      InputGradientRow<Simd, Shape, kChannels, 0, kStep, kCount>(
          d_out + lane, weight, in + y * kInRow + lane, kInPlane, d_in_row + lane, d_in_plane, ci, y);
      if constexpr (kStep == 2) {
        InputGradientRow<Simd, Shape, kChannels, 1, 2, kCount>(d_out + lane, weight, in + y * kInRow + lane,
                                                               kInPlane, d_in_row + lane, d_in_plane, ci, y);
      }
    }
  }
}

}  // namespace dadrl::nn::simd
